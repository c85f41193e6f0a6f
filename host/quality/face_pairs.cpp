#include "host/quality/face_pairs.hpp"

#include <atomic>

#include "host/common/parallel.hpp"
#include "mortise/hanging.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kChunk = 16384;

/// Both halves of a product of 128 bits, added up: every bit of x and y counts.
std::uint64_t mix(std::uint64_t x, std::uint64_t y) {
    const std::uint64_t a = x ^ 0x9e3779b97f4a7c15u;
    const std::uint64_t b = y ^ 0xd1b54a32d192ed03u;
    const std::uint64_t low = (a & 0xffffffffu) * (b & 0xffffffffu);
    const std::uint64_t cross = (a >> 32) * (b & 0xffffffffu) + (low >> 32);
    const std::uint64_t other = (a & 0xffffffffu) * (b >> 32) + (cross & 0xffffffffu);
    const std::uint64_t high = (a >> 32) * (b >> 32) + (cross >> 32) + (other >> 32);
    return high ^ (a * b);
}

/// The same from whichever node a face starts; the negative in the opposite order.
std::uint64_t signed_hash(const NodeId* node, int count) {
    int first = 0;
    for (int k = 1; k < count; ++k) {
        if (node[k] < node[first]) first = k;
    }
    const auto at = [&](int step) -> std::uint64_t { return node[(first + step) % count]; };
    const std::uint64_t next = at(1);
    const std::uint64_t last = at(count - 1);
    const bool forward = next < last;
    const std::uint64_t across = count == 4 ? at(2) : 0xffffffffu;
    const std::uint64_t hash =
        mix(at(0) << 32 | (forward ? next : last), (forward ? last : next) << 32 | across);
    return forward ? hash : 0 - hash;
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
