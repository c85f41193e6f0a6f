#include "host/sizing/thin.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/parallel.hpp"
#include "kernels/shared/lattice.h"

namespace mortise::sizing {
namespace {

constexpr double kOpposite = 0.866;  ///< cosine of 30°
constexpr double kThin = 0.9;        ///< edges
constexpr double kBeside = 1;        ///< edges: feet farther apart than this do not face each other

bool is_thin(const SheetTrace& a, const SheetTrace& b, double edge, double least) {
    if (a.surface == b.surface && a.flat) return false;
    const double turn = dot(a.normal, b.normal) * (a.orientation * b.orientation < 0 ? -1 : 1);
    // Sides that are not known may be either.
    const bool unsure = a.orientation * b.orientation == 0;
    if (unsure ? std::fabs(turn) < kOpposite : turn > -kOpposite) return false;
    const Vec3 d = {b.foot[0] - a.foot[0], b.foot[1] - a.foot[1], b.foot[2] - a.foot[2]};
    const double apart = std::fabs(dot(d, a.normal));
    const double beside = dot(d, d) - apart * apart;
    return apart < kThin * edge && apart >= least && beside < kBeside * kBeside * edge * edge;
}

}  // namespace

void mark_thin(const std::vector<TreeNode>& nodes, int level, const SheetTraces& sheets, double least,
               const MeetNear& meet, int threads, std::vector<std::uint8_t>& which) {
    constexpr std::size_t kChunk = 1024;
    const double edge = std::ldexp(1.0, -level);
    const u32 size = 1u << level;
    std::vector<std::vector<std::uint32_t>> found(chunk_count(nodes.size(), kChunk));
    parallel_chunks(nodes.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i) {
            if (sheets.begin[i] == sheets.begin[i + 1]) continue;
            const u64 code = nodes[i].morton;
            const tape::Cell cell = {{(gather_bits(code) + 0.5) * edge, (gather_bits(code >> 1) + 0.5) * edge,
                                      (gather_bits(code >> 2) + 0.5) * edge},
                                     0.5 * edge};
            for (int k = 14; k < 27; ++k) {  // each pair once
                const u32 x = gather_bits(code) + static_cast<u32>(k % 3) - 1;
                const u32 y = gather_bits(code >> 1) + static_cast<u32>(k / 3 % 3) - 1;
                const u32 z = gather_bits(code >> 2) + static_cast<u32>(k / 9) - 1;
                if (x >= size || y >= size || z >= size) continue;
                const u64 other = morton_encode(x, y, z);
                const auto at =
                    std::lower_bound(nodes.begin(), nodes.end(), other,
                                     [](const TreeNode& node, u64 wanted) { return node.morton < wanted; });
                if (at == nodes.end() || at->morton != other) continue;
                const auto j = static_cast<std::size_t>(at - nodes.begin());
                bool thin = false;
                for (std::uint32_t a = sheets.begin[i]; a < sheets.begin[i + 1] && !thin; ++a) {
                    for (std::uint32_t b = sheets.begin[j]; b < sheets.begin[j + 1] && !thin; ++b) {
                        const SheetTrace& here = sheets.trace[a];
                        const SheetTrace& there = sheets.trace[b];
                        thin = is_thin(here, there, edge, least) &&
                               (here.surface == there.surface ||
                                !meet(here.surface, there.surface, cell, thread));
                    }
                }
                if (!thin) continue;
                found[begin / kChunk].push_back(static_cast<std::uint32_t>(i));
                found[begin / kChunk].push_back(static_cast<std::uint32_t>(j));
            }
        }
    });
    for (const auto& list : found) {
        for (const std::uint32_t i : list) which[i] = 1;
    }
}

}  // namespace mortise::sizing
