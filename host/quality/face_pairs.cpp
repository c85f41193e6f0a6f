#include "host/quality/face_pairs.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>

#include "host/common/parallel.hpp"
#include "host/common/wide.hpp"
#include "mortise/hanging.hpp"

namespace mortise::quality {
namespace {

// Said of every function that returns lanes, though none is ever called.
#pragma GCC diagnostic ignored "-Wpsabi"

constexpr std::size_t kChunk = 16384;

/// A number made of two, of which every bit counts; of numbers or of lanes of them. Multiplications alone
/// carry bits upward only.
template <class Word>
[[gnu::always_inline]] inline Word mix(Word x, const Word& y) {
    x = (x ^ 0x9e3779b97f4a7c15u) * 0xbf58476d1ce4e5b9u;
    x = ((x ^ (x >> 32)) + y) * 0x94d049bb133111ebu;
    x = (x ^ (x >> 29)) * 0xd6e8feb86659fd93u;
    return x ^ (x >> 32);
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

/// Sum of signed_hash() over all faces of some elements of a type.
std::uint64_t sum_one_by_one(ElementType type, const NodeId* nodes, std::size_t count) {
    const LocalFaces faces = local_faces(type);
    const auto per_element = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    std::uint64_t sum = 0;
    for (const NodeId* element = nodes; element != nodes + per_element * count; element += per_element) {
        for (int f = 0; f < faces.count; ++f) {
            const LocalFace& face = faces.faces[f];
            const int corners = face[3] < 0 ? 3 : 4;
            NodeId node[4];
            for (int k = 0; k < corners; ++k) node[k] = element[face[static_cast<std::size_t>(k)]];
            sum += signed_hash(node, corners);
        }
    }
    return sum;
}

#if defined(__GNUC__) && !defined(__clang__)
using lanes::HalfWords;
using lanes::Words;
using Nodes = HalfWords<8>;
static_assert(sizeof(Nodes) == 8 * sizeof(NodeId));

/// Eight faces: two numbers each, as pairs of nodes, and whether the hash counts negatively.
struct Faces {
    Nodes first[2], second[2];
    Nodes is_odd;  ///< 0 or 1
};

/// Adds to as many sums as there are lanes.
template <std::size_t kWidth>
[[gnu::always_inline]] inline void add_hashes(const Faces& faces, Words<kWidth>& sum) {
    const auto part = [](const Nodes& all, std::size_t lane) __attribute__((always_inline)) {
        HalfWords<kWidth> some;
        std::memcpy(&some, reinterpret_cast<const char*>(&all) + lane * sizeof(NodeId), sizeof some);
        return __builtin_convertvector(some, Words<kWidth>);
    };
    for (std::size_t lane = 0; lane < 8; lane += kWidth) {
        const Words<kWidth> first = part(faces.first[0], lane) << 32 | part(faces.first[1], lane);
        const Words<kWidth> second = part(faces.second[0], lane) << 32 | part(faces.second[1], lane);
        const Words<kWidth> sign = Words<kWidth>{} - part(faces.is_odd, lane);
        sum += (mix<Words<kWidth>>(first, second) ^ sign) - sign;
    }
}

template <std::size_t kWidth>
[[gnu::always_inline]] inline std::uint64_t total_of(const Words<kWidth>& sum) {
    std::uint64_t total = 0;
    for (std::size_t lane = 0; lane < kWidth; ++lane) total += sum[lane];
    return total;
}

/// Node k of each face of a hexahedron. There are eight lanes: the last two are a face and its reverse, which
/// cancel.
constexpr std::array<NodeId, 8> lanes_of_faces(std::size_t k) {
    std::array<NodeId, 8> lanes{};
    for (std::size_t f = 0; f < 6; ++f) lanes[f] = static_cast<NodeId>(kHexahedronFaces[f][k]);
    lanes[6] = lanes[0];
    lanes[7] = static_cast<NodeId>(kHexahedronFaces[0][3 - k]);
    return lanes;
}
constexpr std::array<NodeId, 8> kLanes[4] = {lanes_of_faces(0), lanes_of_faces(1), lanes_of_faces(2),
                                             lanes_of_faces(3)};

/// The same of hexahedra, which are most of what there is: all faces of one at a time.
template <std::size_t kWidth>
[[gnu::always_inline]] inline std::uint64_t sum_of_hexahedra_in(const NodeId* nodes, std::size_t count) {
    Nodes place[4];
    std::memcpy(place, kLanes, sizeof place);
    Words<kWidth> sum = {};
    for (std::size_t i = 0; i < count; ++i) {
        Nodes all;
        std::memcpy(&all, nodes + 8 * i, sizeof all);
        const Nodes a = __builtin_shuffle(all, place[0]);
        const Nodes b = __builtin_shuffle(all, place[1]);
        const Nodes c = __builtin_shuffle(all, place[2]);
        const Nodes d = __builtin_shuffle(all, place[3]);
        // The ends of diagonals in order, and then the diagonals.
        const Nodes low_first = a < c ? a : c, high_first = a < c ? c : a;
        const Nodes low_second = b < d ? b : d, high_second = b < d ? d : b;
        const auto is_swapped =
            (low_first > low_second) | ((low_first == low_second) & (high_first > high_second));
        const Faces faces = {{is_swapped ? low_second : low_first, is_swapped ? high_second : high_first},
                             {is_swapped ? low_first : low_second, is_swapped ? high_first : high_second},
                             (a > c) ^ (b > d) ^ is_swapped ? Nodes{} + 1 : Nodes{}};
        add_hashes<kWidth>(faces, sum);
    }
    return total_of<kWidth>(sum);
}
MORTISE_BY_WIDTH(std::uint64_t, sum_of_hexahedra, (const NodeId* nodes, std::size_t count), (nodes, count))

/// Node k of each face of two tetrahedra.
constexpr std::array<NodeId, 8> lanes_of_triangles(std::size_t k) {
    std::array<NodeId, 8> lanes{};
    for (std::size_t f = 0; f < 8; ++f)
        lanes[f] = static_cast<NodeId>(kTetrahedronFaces[f % 4][k]) + (f < 4 ? 0u : 4u);
    return lanes;
}
constexpr std::array<NodeId, 8> kTriangleLanes[3] = {lanes_of_triangles(0), lanes_of_triangles(1),
                                                     lanes_of_triangles(2)};

/// The same of tetrahedra, two at a time.
template <std::size_t kWidth>
[[gnu::always_inline]] inline std::uint64_t sum_of_tetrahedra_in(const NodeId* nodes, std::size_t count) {
    Nodes place[3];
    std::memcpy(place, kTriangleLanes, sizeof place);
    Words<kWidth> sum = {};
    for (std::size_t i = 0; i + 2 <= count; i += 2) {
        Nodes all;
        std::memcpy(&all, nodes + 4 * i, sizeof all);
        const Nodes a = __builtin_shuffle(all, place[0]);
        const Nodes b = __builtin_shuffle(all, place[1]);
        const Nodes c = __builtin_shuffle(all, place[2]);
        const Nodes low = a < b ? a : b, high = a < b ? b : a;
        const Nodes lowest = low < c ? low : c, highest = high < c ? c : high;
        const Nodes upper = high < c ? high : c;
        const Faces faces = {{lowest, low < upper ? upper : low},
                             {highest, Nodes{} - 1},
                             (a > b) ^ (a > c) ^ (b > c) ? Nodes{} + 1 : Nodes{}};
        add_hashes<kWidth>(faces, sum);
    }
    const std::size_t odd_one = count % 2;
    return total_of<kWidth>(sum) +
           sum_one_by_one(ElementType::kTetrahedron, nodes + 4 * (count - odd_one), odd_one);
}
MORTISE_BY_WIDTH(std::uint64_t, sum_of_tetrahedra, (const NodeId* nodes, std::size_t count), (nodes, count))
#define MORTISE_FACES_IN_LANES
#endif

std::uint64_t sum_of_elements(ElementType type, const NodeId* nodes, std::size_t count) {
#ifdef MORTISE_FACES_IN_LANES
    if (type == ElementType::kHexahedron) return sum_of_hexahedra(nodes, count);
    if (type == ElementType::kTetrahedron) return sum_of_tetrahedra(nodes, count);
#endif
    return sum_one_by_one(type, nodes, count);
}

/// Sum of part(begin, end) over the chunks of [0, count).
template <class Part>
std::uint64_t sum_of_chunks(std::size_t count, int threads, const Part& part) {
    std::atomic<std::uint64_t> sum{0};
    parallel_chunks(count, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        sum.fetch_add(part(begin, end), std::memory_order_relaxed);
    });
    return sum;
}

}  // namespace

std::uint64_t sum_of_faces(const Mesh& mesh, int threads) {
    std::uint64_t sum = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const auto per_element = static_cast<std::size_t>(kElementNodes[t]);
        sum += sum_of_chunks(block.size(), threads, [&](std::size_t begin, std::size_t end) {
            return sum_of_elements(static_cast<ElementType>(t), block.nodes.data() + per_element * begin,
                                   end - begin);
        });
    }
    return sum;
}

std::uint64_t sum_of_outer_facets(const FacetBlock& facets, int threads) {
    return sum_of_chunks(facets.size(), threads, [&](std::size_t begin, std::size_t end) {
        std::uint64_t sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
            if (facets.outside[i] != 0) continue;
            const NodeId* node = facets.nodes.data() + 4 * i;
            sum += signed_hash(node, node[2] == node[3] ? 3 : 4);
        }
        return sum;
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
