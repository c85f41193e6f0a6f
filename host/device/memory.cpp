// Buffers: allocation, mapping and copies. On CPU devices host code reaches a buffer by mapping only, which
// costs nothing there; elsewhere uploads and downloads use the driver's transfers.
#include <cstdlib>
#include <cstring>
#include <memory>

#include "host/common/large_pages.hpp"
#include "host/device/device_state.hpp"

namespace mortise::device {
namespace {

/// From here on buffers lie in large pages, whose last is half empty as a rule.
constexpr std::size_t kLargeBuffer = 4 * kLargePage;

void check_range(std::size_t bytes, std::size_t offset, std::size_t size, const char* what) {
    if (offset > size || bytes > size - offset) {
        misuse(std::string(what) + ": bytes " + std::to_string(offset) + " to " +
               std::to_string(offset + bytes) + " lie outside a buffer of " + std::to_string(size) +
               " bytes");
    }
}

void CL_CALLBACK give_back(cl_mem, void* host) { std::free(host); }

/// Memory of ours that a device on it uses, in large pages; the driver's where there is none.
compute::buffer in_large_pages(const compute::context& context, std::size_t bytes) {
    const std::size_t size = (bytes + kLargePage - 1) / kLargePage * kLargePage;
    std::unique_ptr<void, decltype(&std::free)> host(std::aligned_alloc(kLargePage, size), &std::free);
    if (!host) return compute::buffer(context, bytes);
    ask_for_large_pages(host.get(), size);
    compute::buffer memory(context, bytes, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, host.get());
    // When nothing that has been launched uses it any more.
    memory.set_destructor_callback(&give_back, host.get());
    host.release();
    return memory;
}

}  // namespace

void* Mapping::data() const { return implementation_ ? implementation_->data : nullptr; }
std::size_t Mapping::bytes() const { return implementation_ ? implementation_->bytes : 0; }

Buffer Device::allocate(std::size_t bytes) {
    Implementation& self = *implementation_;
    const auto does_not_fit = [&](cl_int code) {
        // The limits are asked for again: some drivers let them grow while a program runs.
        const DeviceInfo now = describe(self.found.platform, self.found.id);
        fail(code, "clCreateBuffer",
             "a buffer of " + amount(bytes) + " does not fit on " + now.name +
                 ", whose largest allocation is " + amount(now.max_allocation_bytes) + " of " +
                 amount(now.global_bytes) + " with " + amount(self.memory->bytes) + " in use");
    };
    // GPU drivers allocate at the first launch: what can never fit is refused here, where its size is known.
    if (!self.found.is_cpu && bytes > info().global_bytes) does_not_fit(CL_MEM_OBJECT_ALLOCATION_FAILURE);
    Buffer buffer;
    try {
        const bool is_large = self.shares_memory() && bytes >= kLargeBuffer;
        buffer.implementation_ = std::make_shared<Buffer::Implementation>(
            is_large ? in_large_pages(self.context, bytes) : compute::buffer(self.context, bytes), bytes,
            self.memory);
    } catch (const compute::opencl_error& error) {
        does_not_fit(error.error_code());
    }
    buffer.bytes_ = bytes;
    return buffer;
}

Buffer Device::wrap(void* host, std::size_t bytes) {
    if (bytes == 0) return allocate(0);
    Implementation& self = *implementation_;
    Buffer buffer;
    if (!self.shares_memory()) {
        buffer = allocate(bytes);
        buffer.implementation_->host = host;
        return buffer;
    }
    guarded("clCreateBuffer", "using " + amount(bytes) + " of host memory on " + info().name, [&] {
        compute::buffer memory(self.context, bytes, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, host);
        buffer.implementation_ =
            std::make_shared<Buffer::Implementation>(std::move(memory), bytes, self.memory);
    });
    buffer.bytes_ = bytes;
    return buffer;
}

// Mapping waits, and moves nothing where the buffer is the host's memory.
void Device::sync_to_host(Buffer& buffer) {
    void* const host = buffer.bytes() > 0 ? buffer.implementation_->host : nullptr;
    if (host != nullptr) {
        download_bytes(buffer, host, buffer.bytes(), 0);
    } else {
        map_bytes(buffer, Access::kRead, buffer.bytes(), 0);
    }
}

void Device::sync_to_device(Buffer& buffer) {
    const void* const host = buffer.bytes() > 0 ? buffer.implementation_->host : nullptr;
    if (host != nullptr) {
        upload_bytes(buffer, host, buffer.bytes(), 0);
    } else {
        map_bytes(buffer, Access::kWrite, buffer.bytes(), 0);
    }
}

Mapping Device::map_bytes(Buffer& buffer, Access access, std::size_t bytes, std::size_t offset) {
    Mapping mapping;
    check_range(bytes, offset, buffer.bytes(), "mapping");
    if (bytes == 0) return mapping;
    cl_map_flags flags = CL_MAP_READ;
    if (access == Access::kWrite) flags = CL_MAP_WRITE_INVALIDATE_REGION;
    if (access == Access::kReadWrite) flags = CL_MAP_READ | CL_MAP_WRITE;
    compute::command_queue& queue = implementation_->queue;
    void* const data = guarded("clEnqueueMapBuffer", "mapping " + amount(bytes), [&] {
        return queue.enqueue_map_buffer(buffer.implementation_->memory, flags, offset, bytes);
    });
    mapping.implementation_ = std::make_shared<Mapping::Implementation>();
    mapping.implementation_->queue = queue;
    mapping.implementation_->buffer = buffer.implementation_;
    mapping.implementation_->data = data;
    mapping.implementation_->bytes = bytes;
    ++buffer.implementation_->mappings;
    return mapping;
}

void Device::upload_bytes(Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset) {
    check_range(bytes, offset, buffer.bytes(), "upload");
    if (bytes == 0) return;
    if (implementation_->shares_memory()) {
        std::memcpy(map_bytes(buffer, Access::kWrite, bytes, offset).data(), data, bytes);
    } else {
        guarded("clEnqueueWriteBuffer", "uploading " + amount(bytes), [&] {
            implementation_->queue.enqueue_write_buffer(buffer.implementation_->memory, offset, bytes, data);
        });
    }
}

void Device::download_bytes(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset) {
    check_range(bytes, offset, buffer.bytes(), "download");
    if (bytes == 0) return;
    if (implementation_->shares_memory()) {
        Buffer same;  // reading does not change the buffer, but a mapping is counted in it
        same.implementation_ = buffer.implementation_;
        same.bytes_ = buffer.bytes_;
        std::memcpy(data, map_bytes(same, Access::kRead, bytes, offset).data(), bytes);
    } else {
        guarded("clEnqueueReadBuffer", "downloading " + amount(bytes), [&] {
            implementation_->queue.enqueue_read_buffer(buffer.implementation_->memory, offset, bytes, data);
        });
    }
}

void Device::fill_zero(Buffer& buffer, std::size_t bytes, std::size_t offset) {
    check_range(bytes, offset, buffer.bytes(), "filling");
    if (bytes == 0) return;
    guarded("clEnqueueFillBuffer", "filling " + amount(bytes), [&] {
        const unsigned char zero = 0;
        implementation_->queue.enqueue_fill_buffer(buffer.implementation_->memory, &zero, 1, offset, bytes);
    });
}

void Device::copy(const Buffer& from, Buffer& to, std::size_t bytes, std::size_t from_offset,
                  std::size_t to_offset) {
    check_range(bytes, from_offset, from.bytes(), "copying from");
    check_range(bytes, to_offset, to.bytes(), "copying to");
    if (bytes == 0) return;
    guarded("clEnqueueCopyBuffer", "copying " + amount(bytes), [&] {
        implementation_->queue.enqueue_copy_buffer(from.implementation_->memory, to.implementation_->memory,
                                                   from_offset, to_offset, bytes);
    });
}

MemoryUse Device::memory() const { return *implementation_->memory; }

}  // namespace mortise::device
