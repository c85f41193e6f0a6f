#include "host/quality/face_pairs.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <vector>

#include "host/common/parallel.hpp"
#include "host/common/wide.hpp"
#include "mortise/hanging.hpp"

namespace mortise::quality {
namespace {

// Said of every function that returns lanes, though none is ever called.
#pragma GCC diagnostic ignored "-Wpsabi"

constexpr std::size_t kFaceChunk = 16384;
constexpr NodeId kNoNode = 0xffffffffu;

/// What a face counts, of numbers or of lanes of them.
template <class Word>
struct Hash {
    Word low, high;
};

/// Two numbers made of four, of which every bit counts. Multiplications alone carry bits upward only. No two
/// fours that agree in their first two numbers, or in their last two, give the same.
template <class Word>
[[gnu::always_inline]] inline Hash<Word> mix(const Word& a, const Word& b, const Word& c, const Word& d) {
    Word p = (a ^ 0x9e3779b9u) * 0x85ebca6bu;
    p ^= p >> 15;
    Word q = (b ^ p) * 0xc2b2ae35u;
    q ^= q >> 13;
    p = ((p + q) ^ c) * 0x27d4eb2fu;
    p ^= p >> 16;
    q = ((p + d) ^ q) * 0x165667b1u;
    q ^= q >> 15;
    p = (p + q) * 0x9e3779b1u;
    p ^= p >> 14;
    q = (q + p) * 0x2c1b3c6du;
    q ^= q >> 16;
    p = (p ^ q) * 0x297a2d39u;
    p ^= p >> 15;
    return {p, q};
}

using Nodes = lanes::Words<8>;
static_assert(sizeof(Nodes) == 8 * sizeof(NodeId));

/// What a comparison gives, as all bits of a number or of each lane.
NodeId all_bits(int holds) { return NodeId{} - static_cast<NodeId>(holds); }
template <class Lanes>
[[gnu::always_inline]] inline Nodes all_bits(const Lanes& lanes) {
    return (Nodes)lanes;
}

/// The negative where `is_odd` has all bits.
template <class Word>
[[gnu::always_inline]] inline Hash<Word> with_sign(const Hash<Word>& hash, const Word& is_odd) {
    return {(hash.low ^ is_odd) - is_odd, (hash.high ^ is_odd) - is_odd};
}

/// The same from whichever node a face starts; the negative in the opposite order. A quadrilateral is told by
/// its diagonals, put in order by their ends and by their lower ones: a turn by one node changes the order of
/// one diagonal and that of the pair, a reversal those of both and of the pair. No branch: this runs over
/// every face of every mesh.
template <class Word>
[[gnu::always_inline]] inline Hash<Word> hash_of_quadrilateral(const Word& a, const Word& b, const Word& c,
                                                               const Word& d) {
    const Word low_first = a < c ? a : c, high_first = a < c ? c : a;
    const Word low_second = b < d ? b : d, high_second = b < d ? d : b;
    const auto is_swapped =
        (low_first > low_second) | ((low_first == low_second) & (high_first > high_second));
    return with_sign(mix<Word>(is_swapped ? low_second : low_first, is_swapped ? high_second : high_first,
                               is_swapped ? low_first : low_second, is_swapped ? high_first : high_second),
                     all_bits((a > c) ^ (b > d) ^ is_swapped));
}

template <class Word>
[[gnu::always_inline]] inline Hash<Word> hash_of_triangle(const Word& a, const Word& b, const Word& c) {
    const Word low = a < b ? a : b, high = a < b ? b : a;
    const Word lowest = low < c ? low : c, highest = high < c ? c : high;
    const Word upper = high < c ? high : c;
    return with_sign(mix<Word>(lowest, low < upper ? upper : low, highest, Word{} + kNoNode),
                     all_bits((a > b) ^ (a > c) ^ (b > c)));
}

FaceSum signed_hash(const NodeId* n, int count) {
    const Hash<NodeId> hash =
        count == 4 ? hash_of_quadrilateral(n[0], n[1], n[2], n[3]) : hash_of_triangle(n[0], n[1], n[2]);
    return {hash.low, hash.high};
}

/// Sum of signed_hash() over all faces of some elements of a type.
FaceSum sum_one_by_one(ElementType type, const NodeId* nodes, std::size_t count) {
    const LocalFaces faces = local_faces(type);
    const auto per_element = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    FaceSum sum;
    for (const NodeId* element = nodes; element != nodes + per_element * count; element += per_element) {
        for (int f = 0; f < faces.count; ++f) {
            const LocalFace& face = faces.faces[f];
            const int corners = static_cast<int>(corner_count(face));
            NodeId node[4];
            for (int k = 0; k < corners; ++k) node[k] = element[face[static_cast<std::size_t>(k)]];
            sum += signed_hash(node, corners);
        }
    }
    return sum;
}

#if defined(__GNUC__) && !defined(__clang__)
/// Sums of the hashes of eight faces, lane by lane.
struct LaneSum {
    Nodes low = {}, high = {};

    [[gnu::always_inline]] void add(const Hash<Nodes>& hash) {
        low += hash.low;
        high += hash.high;
    }

    [[gnu::always_inline]] FaceSum total() const {
        FaceSum sum;
        for (std::size_t lane = 0; lane < 8; ++lane) sum += FaceSum{low[lane], high[lane]};
        return sum;
    }
};

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
template <std::size_t>
[[gnu::always_inline]] inline FaceSum sum_of_hexahedra_in(const NodeId* nodes, std::size_t count) {
    Nodes place[4];
    std::memcpy(place, kLanes, sizeof place);
    LaneSum sum;
    for (std::size_t i = 0; i < count; ++i) {
        Nodes all;
        std::memcpy(&all, nodes + 8 * i, sizeof all);
        sum.add(
            hash_of_quadrilateral<Nodes>(__builtin_shuffle(all, place[0]), __builtin_shuffle(all, place[1]),
                                         __builtin_shuffle(all, place[2]), __builtin_shuffle(all, place[3])));
    }
    return sum.total();
}
MORTISE_BY_WIDTH(FaceSum, sum_of_hexahedra, (const NodeId* nodes, std::size_t count), (nodes, count))

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
template <std::size_t>
[[gnu::always_inline]] inline FaceSum sum_of_tetrahedra_in(const NodeId* nodes, std::size_t count) {
    Nodes place[3];
    std::memcpy(place, kTriangleLanes, sizeof place);
    LaneSum sum;
    for (std::size_t i = 0; i + 2 <= count; i += 2) {
        Nodes all;
        std::memcpy(&all, nodes + 4 * i, sizeof all);
        sum.add(hash_of_triangle<Nodes>(__builtin_shuffle(all, place[0]), __builtin_shuffle(all, place[1]),
                                        __builtin_shuffle(all, place[2])));
    }
    const std::size_t odd_one = count % 2;
    return sum.total() + sum_one_by_one(ElementType::kTetrahedron, nodes + 4 * (count - odd_one), odd_one);
}
MORTISE_BY_WIDTH(FaceSum, sum_of_tetrahedra, (const NodeId* nodes, std::size_t count), (nodes, count))
#define MORTISE_FACES_IN_LANES
#endif

FaceSum sum_of_elements(ElementType type, const NodeId* nodes, std::size_t count) {
#ifdef MORTISE_FACES_IN_LANES
    if (type == ElementType::kHexahedron) return sum_of_hexahedra(nodes, count);
    if (type == ElementType::kTetrahedron) return sum_of_tetrahedra(nodes, count);
#endif
    return sum_one_by_one(type, nodes, count);
}

/// Sum of part(begin, end) over the chunks of [0, count).
template <class Part>
FaceSum sum_of_chunks(std::size_t count, int threads, const Part& part) {
    std::vector<FaceSum> sums(chunk_count(count, kFaceChunk));
    parallel_chunks(count, kFaceChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        sums[begin / kFaceChunk] = part(begin, end);
    });
    return std::accumulate(sums.begin(), sums.end(), FaceSum{});
}

}  // namespace

FaceSum sum_of_faces(const Mesh& mesh, int threads) {
    FaceSum sum;
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

FaceSum sum_of_outer_facets(const FacetBlock& facets, int threads) {
    return sum_of_chunks(facets.size(), threads, [&](std::size_t begin, std::size_t end) {
        FaceSum sum;
        for (std::size_t i = begin; i < end; ++i) {
            if (facets.outside[i] != 0) continue;
            const FacetNodes node = facets.facet(i);
            sum += signed_hash(node.begin(), static_cast<int>(node.size()));
        }
        return sum;
    });
}

FaceSum sum_of_hanging_faces(const HangingNodes& hanging) {
    FaceSum sum;
    for (const HangingFace& face : hanging_faces(hanging)) {
        sum += signed_hash(face.whole.data(), 4);
        for (const auto& quarter : face.quarters) sum -= signed_hash(quarter.data(), 4);
    }
    return sum;
}

}  // namespace mortise::quality
