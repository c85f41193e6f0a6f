#include "host/quality/face_pairs.hpp"

#include <algorithm>
#include <atomic>

#include "host/common/parallel.hpp"
#include "mortise/hanging.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kChunk = 16384;

__extension__ using UInt128 = unsigned __int128;  // a GNU extension; the alias keeps -Wpedantic quiet

/// Both halves of a product of 128 bits, added up: every bit of x and y counts.
std::uint64_t mix(std::uint64_t x, std::uint64_t y) {
    const UInt128 product = UInt128{x ^ 0x9e3779b97f4a7c15u} * (y ^ 0xd1b54a32d192ed03u);
    return static_cast<std::uint64_t>(product >> 64) ^ static_cast<std::uint64_t>(product);
}

/// Two nodes in ascending order as one number; `odd` changes if they were not.
std::uint64_t ordered_pair(NodeId a, NodeId b, unsigned& odd) {
    odd ^= a > b;
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

/// The same from whichever node a face starts; the negative in the opposite order. A quadrilateral is told by
/// its diagonals, put in order by their ends and by their lower ones: a turn by one node changes the order of
/// one diagonal and that of the pair, a reversal those of both and of the pair. No branch: this runs over
/// every face of every mesh.
std::uint64_t signed_hash(const NodeId* node, int count) {
    unsigned odd = 0;
    std::uint64_t first, second;
    if (count == 4) {
        first = ordered_pair(node[0], node[2], odd);
        second = ordered_pair(node[1], node[3], odd);
        odd ^= first > second;
        const std::uint64_t lower = std::min(first, second);
        second = std::max(first, second);
        first = lower;
    } else {
        const NodeId low = std::min(node[0], node[1]), high = std::max(node[0], node[1]);
        const NodeId lowest = std::min(low, node[2]), middle = std::max(low, std::min(high, node[2]));
        odd ^= (node[0] > node[1]) ^ (node[0] > node[2]) ^ (node[1] > node[2]);
        first = std::uint64_t{lowest} << 32 | middle;
        second = std::uint64_t{std::max(high, node[2])} << 32 | 0xffffffffu;
    }
    const std::uint64_t hash = mix(first, second);
    return odd != 0 ? 0 - hash : hash;
}

/// Sum of hash(i) over all i below `count`.
template <class Hash>
std::uint64_t sum_of(std::size_t count, int threads, const Hash& hash) {
    std::atomic<std::uint64_t> sum{0};
    parallel_chunks(count, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        std::uint64_t part = 0;
        for (std::size_t i = begin; i < end; ++i) part += hash(i);
        sum.fetch_add(part, std::memory_order_relaxed);
    });
    return sum;
}

}  // namespace

std::uint64_t sum_of_faces(const Mesh& mesh, int threads) {
    std::uint64_t sum = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const LocalFaces faces = local_faces(static_cast<ElementType>(t));
        const ElementBlock& block = mesh.elements[t];
        const auto per_element = static_cast<std::size_t>(kElementNodes[t]);
        sum += sum_of(block.size(), threads, [&](std::size_t i) {
            const NodeId* nodes = block.nodes.data() + per_element * i;
            std::uint64_t part = 0;
            for (int f = 0; f < faces.count; ++f) {
                const LocalFace& face = faces.faces[f];
                const int count = face[3] < 0 ? 3 : 4;
                NodeId node[4];
                for (int k = 0; k < count; ++k) node[k] = nodes[face[static_cast<std::size_t>(k)]];
                part += signed_hash(node, count);
            }
            return part;
        });
    }
    return sum;
}

std::uint64_t sum_of_outer_facets(const FacetBlock& facets, int threads) {
    return sum_of(facets.size(), threads, [&](std::size_t i) {
        if (facets.outside[i] != 0) return std::uint64_t{0};
        const NodeId* node = facets.nodes.data() + 4 * i;
        return signed_hash(node, node[2] == node[3] ? 3 : 4);
    });
}

std::uint64_t sum_of_hanging_faces(const HangingNodes& hanging) {
    std::uint64_t sum = 0;
    for (const HangingFace& face : hanging_faces(hanging)) {
        sum += signed_hash(face.whole.data(), 4);
        for (const auto& quarter : face.quarters) sum -= signed_hash(quarter.data(), 4);
    }
    return sum;
}

}  // namespace mortise::quality
