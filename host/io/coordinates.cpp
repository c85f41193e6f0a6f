#include "host/io/coordinates.hpp"

#include <algorithm>

#include "host/io/vtu_layout.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"

namespace mortise::io {

ByteSource Coordinates::source() const {
    if (scale_ == 1) return memory_source(points_.data());
    return value_source<double>(
        [points = points_.data(), scale = scale_](std::size_t first, std::size_t last, double* out) {
            for (std::size_t i = first; i < last; ++i) *out++ = points[i] * scale;
        });
}

void Coordinates::write(TemporaryFile& file) const {
    const ByteSource bytes = source();
    const std::size_t end = size() * sizeof(double);
    std::vector<double> space(kBlockSize / sizeof(double));
    for (std::size_t begin = 0; begin < end; begin += kBlockSize) {
        const std::size_t part = std::min(kBlockSize, end - begin);
        file.write(bytes(begin, begin + part, reinterpret_cast<char*>(space.data())), part);
    }
}

void check_scale(double scale, const std::string& path) {
    if (scale >= kLeastScale && scale <= kMostScale) return;
    throw Error(ExitCode::kUsage,
                "cannot write '" + path + "': MeshFileOptions::scale must be from 1e-12 to 1e12");
}

}  // namespace mortise::io
