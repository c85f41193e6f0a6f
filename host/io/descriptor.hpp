// Whole transfers by file descriptor (POSIX): interrupted and partial ones are continued.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>

namespace mortise::io {

/// Transfers all bytes with pread or pwrite; returns 0 or errno, `at_end` if a transfer comes to nothing.
template <class Transfer, class Byte>
int transfer_all(const Transfer& transfer, int descriptor, Byte* bytes, std::size_t size,
                 std::uint64_t offset, int at_end) {
    while (size > 0) {
        const ssize_t count = transfer(descriptor, bytes, size, static_cast<off_t>(offset));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return count < 0 ? errno : at_end;
        bytes += count;
        size -= static_cast<std::size_t>(count);
        offset += static_cast<std::uint64_t>(count);
    }
    return 0;
}

inline int write_all(int descriptor, const char* bytes, std::size_t size, std::uint64_t offset) {
    return transfer_all(pwrite, descriptor, bytes, size, offset, ENOSPC);
}

/// `at_end`: what to return if the file is shorter.
inline int read_all(int descriptor, char* bytes, std::size_t size, std::uint64_t offset, int at_end) {
    return transfer_all(pread, descriptor, bytes, size, offset, at_end);
}

}  // namespace mortise::io
