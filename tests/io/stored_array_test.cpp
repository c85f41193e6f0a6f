// Arrays in files, plain: the right bytes wherever an array begins, from sources that are asked for whole
// values only.
#include "host/io/stored_array.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <fstream>
#include <iterator>
#include <string>

#include "folder.hpp"

using namespace mortise;
using namespace mortise::io;

TEST_CASE("a plain array is what its source gives, wherever it begins in the file") {
    constexpr std::size_t part = std::size_t{1} << 18;
    const Folder folder;
    const auto byte = [](std::size_t i) { return static_cast<char>((i * 2654435761u) >> 13); };
    for (const std::size_t before : {std::size_t{0}, std::size_t{3}, part - 9, part - 8, part + 1}) {
        for (const std::size_t size :
             {std::size_t{0}, std::size_t{1}, std::size_t{8}, part - 1, part, 3 * part + 5}) {
            CAPTURE(before);
            CAPTURE(size);
            std::atomic<int> broken{0};
            const ByteSource source = [&](std::size_t begin, std::size_t end, char* space) {
                if (begin % 8 != 0 || (end % 8 != 0 && end != size) || begin >= end || end > size ||
                    end - begin > kBlockSize)
                    ++broken;
                for (std::size_t i = begin; i < end; ++i) space[i - begin] = byte(i);
                return static_cast<const char*>(space);
            };
            const std::string path = folder.path / "array";
            TemporaryFile file(path);
            file.write(std::string(before, 'x'));
            write_array(file, size, source, {Coding::kPlain});
            file.write("end");
            file.commit();
            std::string expected(before, 'x');
            const std::uint64_t count = size;
            expected.append(reinterpret_cast<const char*>(&count), sizeof count);
            for (std::size_t i = 0; i < size; ++i) expected += byte(i);
            std::ifstream stored(path, std::ios::binary);
            const std::string found{std::istreambuf_iterator<char>(stored), {}};
            CHECK(broken == 0);
            CHECK(found == expected + "end");
        }
    }
}
