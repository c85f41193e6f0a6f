#include "host/improve/scope.hpp"

#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/improve/poor_cells.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kScopeChunk = 65536;

}  // namespace

Scope::Scope(const tape::BoundModel& model, const std::vector<tape::Pole>& poles, int level, double goal,
             int threads)
    : frame_(make_frame(model, level)), goal_(goal), threads_(threads), cells_(level, nullptr) {
    for (const Tip& tip : find_tips(model, poles, level)) poor_.push_back(cells_.index(tip.point));
}

void Scope::add_poor(const Mesh& part) {
    const std::vector<CellId> found =
        poor_cells(part, frame_, cells_, Places{}, volume_rounding(frame_, 0), goal_, threads_);
    poor_.insert(poor_.end(), found.begin(), found.end());
}

void Scope::spread(int reach) {
    sort_unique(poor_);
    bricks_.clear();
    const std::int64_t last = (std::int64_t{1} << frame_.level) - 1;
    for (const CellId cell : poor_) {
        cells_.set_cube(cell, reach);
        std::array<std::int64_t, 3> low = cells_.cell_of(cell), high = low;
        for (std::size_t j = 0; j < 3; ++j) {
            low[j] = std::clamp<std::int64_t>(low[j] - reach - 1, 0, last) >> kBrickLevels;
            high[j] = std::clamp<std::int64_t>(high[j] + reach + 1, 0, last) >> kBrickLevels;
        }
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
            for (std::int64_t y = low[1]; y <= high[1]; ++y) {
                for (std::int64_t x = low[0]; x <= high[0]; ++x) {
                    bricks_.push_back(
                        morton_encode(static_cast<u32>(x), static_cast<u32>(y), static_cast<u32>(z)));
                }
            }
        }
        if (bricks_.size() > kScopeChunk && bricks_.size() == bricks_.capacity()) sort_unique(bricks_);
    }
    sort_unique(bricks_);
}

ElementNumbers Scope::select(const Mesh& part) const {
    ElementNumbers result;
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<std::size_t>(t);
        const std::size_t count = part.elements[type].size();
        std::vector<std::vector<std::uint32_t>> found(chunk_count(count, kScopeChunk));
        parallel_chunks(count, kScopeChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                if (cells_.test(cells_.index(place_of(part, frame_, t, i))))
                    found[begin / kScopeChunk].push_back(static_cast<std::uint32_t>(i));
            }
        });
        for (const auto& list : found) result[type].insert(result[type].end(), list.begin(), list.end());
    }
    return result;
}

bool Scope::touches(std::uint64_t begin, std::uint64_t end) const {
    const auto found = std::lower_bound(bricks_.begin(), bricks_.end(), begin >> (3 * kBrickLevels));
    return found != bricks_.end() && *found << (3 * kBrickLevels) < end;
}

}  // namespace mortise::improve
