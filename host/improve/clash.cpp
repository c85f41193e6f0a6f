#include "host/improve/clash.hpp"

#include <algorithm>

#include "host/common/parallel.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kChunk = 4096;

struct MovedNode {
    Point at;
    std::uint32_t block;

    bool operator<(const MovedNode& other) const { return at < other.at; }
};

void find_coincident(const PassResult& pass, double same, int threads, std::vector<std::uint32_t>& clashing) {
    std::vector<MovedNode> moved;
    for (std::size_t n = 0; n < pass.after.size(); ++n) {
        if (pass.after[n] != pass.before[n]) moved.push_back({pass.after[n], pass.owner[n]});
    }
    if (moved.empty()) return;
    std::sort(moved.begin(), moved.end());
    std::vector<std::vector<std::uint32_t>> found(chunk_count(pass.after.size(), kChunk));
    parallel_chunks(pass.after.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t n = begin; n < end; ++n) {
            if (pass.owner[n] == kNone) continue;  // no element has it any more
            const Point& at = pass.after[n];
            const auto first =
                std::lower_bound(moved.begin(), moved.end(), at[0] - same,
                                 [](const MovedNode& node, double x) { return node.at[0] < x; });
            for (auto m = first; m != moved.end() && m->at[0] <= at[0] + same; ++m) {
                if (m->block != pass.owner[n] && squared_length(m->at - at) < same * same)
                    found[begin / kChunk].push_back(m->block);
            }
        }
    });
    for (const auto& list : found) clashing.insert(clashing.end(), list.begin(), list.end());
}

/// A face all of whose nodes other blocks have, too.
struct SharedFace {
    std::array<ZoneNode, 3> node;  ///< ascending
    std::uint32_t block;
    bool even;

    bool operator<(const SharedFace& other) const { return node < other.node; }
};

void find_crowded_faces(const PassResult& pass, std::vector<std::uint32_t>& clashing) {
    std::vector<SharedFace> faces;
    for (std::uint32_t block = 0; block + 1 < pass.first.size(); ++block) {
        for (std::size_t i = pass.first[block]; i < pass.first[block + 1]; ++i) {
            const Tetrahedron& t = pass.tetrahedra[i];
            for (const auto& o : kOpposite) {
                std::array<ZoneNode, 3> n = {t.node[o[0]], t.node[o[1]], t.node[o[2]]};
                if (pass.owner[n[0]] < pass.shared || pass.owner[n[1]] < pass.shared ||
                    pass.owner[n[2]] < pass.shared)
                    continue;
                const bool even = sort_three(n);
                faces.push_back({n, block, even});
            }
        }
    }
    std::sort(faces.begin(), faces.end());
    for (std::size_t i = 0; i < faces.size();) {
        std::size_t end = i + 1;
        while (end < faces.size() && faces[end].node == faces[i].node) ++end;
        if (end - i > 2 || (end - i == 2 && faces[i].even == faces[i + 1].even)) {
            for (std::size_t k = i; k < end; ++k) clashing.push_back(faces[k].block);
        }
        i = end;
    }
}

}  // namespace

std::vector<std::uint32_t> find_clashes(const PassResult& pass, double same, int threads) {
    std::vector<std::uint32_t> clashing;
    find_coincident(pass, same, threads, clashing);
    find_crowded_faces(pass, clashing);
    std::sort(clashing.begin(), clashing.end());
    clashing.erase(std::unique(clashing.begin(), clashing.end()), clashing.end());
    return clashing;
}

}  // namespace mortise::improve
