#include "host/tetrahedra/split.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "host/common/compaction.hpp"
#include "host/common/cubes.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "mortise/error.hpp"

namespace mortise::tetrahedra {
namespace {

constexpr std::size_t kChunk = 4096;
constexpr std::size_t kMostNodes = 8;

using Tetrahedron = std::array<NodeId, 4>;

double determinant(const std::vector<double>& points, const Tetrahedron& t) {
    const double* o = points.data() + 3 * std::size_t{t[0]};
    double edge[3][3];
    for (std::size_t i = 0; i < 3; ++i) {
        const double* p = points.data() + 3 * std::size_t{t[i + 1]};
        for (std::size_t j = 0; j < 3; ++j) edge[i][j] = p[j] - o[j];
    }
    return edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) +
           edge[0][1] * (edge[1][2] * edge[2][0] - edge[1][0] * edge[2][2]) +
           edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]);
}

/// Order of the nodes of a mesh: by rank, then by number. Nodes without a rank are ranked by their numbers.
class Order {
  public:
    explicit Order(const std::vector<NodeId>* rank) : rank_(rank) {}
    std::uint64_t key(NodeId node) const {
        const NodeId rank = rank_ != nullptr && node < rank_->size() ? (*rank_)[node] : node;
        return std::uint64_t{rank} << 32 | node;
    }

  private:
    const std::vector<NodeId>* rank_;
};

/// Place of the least key. Chosen without branches, which nothing could predict here.
std::size_t lowest(const std::uint64_t* key, std::size_t count) {
    std::size_t low = 0;
    for (std::size_t k = 1; k < count; ++k) low = key[k] < key[low] ? k : low;
    return low;
}

/// A face of an element by its nodes' places in the element.
struct FaceRow {
    std::array<std::uint8_t, 4> node;
    std::uint8_t count;
};

/// The faces of an element that a cone covers, by the place of its apex; the last row is for the centre.
struct ConeTable {
    std::array<std::array<FaceRow, 6>, kMostNodes + 1> faces;
    std::array<std::uint8_t, kMostNodes + 1> count{};
    std::array<std::uint8_t, kMostNodes + 1> pieces{};
};

ConeTable make_table(ElementType type) {
    ConeTable table{};
    const LocalFaces faces = local_faces(type);
    for (int apex = 0; apex <= static_cast<int>(kMostNodes); ++apex) {
        const auto row = static_cast<std::size_t>(apex);
        for (int f = 0; f < faces.count; ++f) {
            const LocalFace& face = faces.faces[f];
            if (std::find(face.begin(), face.end(), apex) != face.end()) continue;
            FaceRow& out = table.faces[row][table.count[row]++];
            out.count = corner_count(face);
            for (std::size_t k = 0; k < out.count; ++k) out.node[k] = static_cast<std::uint8_t>(face[k]);
            table.pieces[row] = static_cast<std::uint8_t>(table.pieces[row] + out.count - 2);
        }
    }
    return table;
}

/// The pieces of one element.
struct Pieces {
    std::array<Tetrahedron, 12> list;
    std::size_t count = 0;
};

/// Splits elements of one type.
class Splitter {
  public:
    Splitter(ElementType type, const Order& order)
        : order_(order),
          table_(make_table(type)),
          size_(static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)])),
          // The lowest node may be any: each is in as many triangles as the others of its kind, but for the
          // pyramid, whose tip and base both leave two.
          usual_count_(type == ElementType::kTetrahedron ? 1 : table_.pieces[0]) {}

    std::size_t size() const { return size_; }
    std::size_t usual_count() const { return usual_count_; }
    std::size_t count_from_centre() const { return table_.pieces[kMostNodes]; }

    /// From the lowest node.
    void split(const NodeId* node, Pieces& out) const {
        if (size_ == 4) {
            out.list[0] = {node[0], node[1], node[2], node[3]};
            out.count = 1;
            return;
        }
        std::array<std::uint64_t, kMostNodes> key{};
        for (std::size_t k = 0; k < size_; ++k) key[k] = order_.key(node[k]);
        const std::size_t low = lowest(key.data(), size_);
        cone(node, key, low, node[low], out);
    }

    void split_from(NodeId centre, const NodeId* node, Pieces& out) const {
        std::array<std::uint64_t, kMostNodes> key{};
        for (std::size_t k = 0; k < size_; ++k) key[k] = order_.key(node[k]);
        cone(node, key, kMostNodes, centre, out);
    }

  private:
    /// Outward triangles make a positive tetrahedron as (a, c, b, apex).
    void cone(const NodeId* node, const std::array<std::uint64_t, kMostNodes>& key, std::size_t row,
              NodeId apex, Pieces& out) const {
        out.count = 0;
        for (std::size_t f = 0; f < table_.count[row]; ++f) {
            const FaceRow& face = table_.faces[row][f];
            std::size_t low = 0;
            if (face.count == 4) {
                const std::array<std::uint64_t, 4> keys = {key[face.node[0]], key[face.node[1]],
                                                           key[face.node[2]], key[face.node[3]]};
                low = lowest(keys.data(), 4);
            }
            const auto at = [&](std::size_t k) { return node[face.node[k % face.count]]; };
            for (std::size_t k = 1; k + 1 < face.count; ++k)
                out.list[out.count++] = {at(low), at(low + k + 1), at(low + k), apex};
        }
    }

    const Order& order_;
    ConeTable table_;
    std::size_t size_;
    std::size_t usual_count_;
};

bool all_positive(const std::vector<double>& points, const Pieces& pieces) {
    return std::all_of(pieces.list.begin(), pieces.list.begin() + static_cast<std::ptrdiff_t>(pieces.count),
                       [&](const Tetrahedron& t) { return determinant(points, t) > 0; });
}

/// Elements, ascending, that their lowest node does not split into positive tetrahedra.
std::vector<std::size_t> find_turned(const std::vector<double>& points, const ElementBlock& block,
                                     const Splitter& splitter, int threads) {
    std::vector<std::vector<std::size_t>> found(chunk_count(block.size(), kChunk));
    parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        Pieces pieces;
        for (std::size_t i = begin; i < end; ++i) {
            splitter.split(block.nodes.data() + i * splitter.size(), pieces);
            if (!all_positive(points, pieces)) found[begin / kChunk].push_back(i);
        }
    });
    std::vector<std::size_t> turned;
    append_lists(found, 1, turned);
    return turned;
}

/// One type's share of the tetrahedra.
struct Share {
    Splitter splitter;
    std::vector<std::size_t> turned;  ///< elements to split from their centres, ascending
    NodeId first_centre;              ///< node; the others follow
    std::size_t begin;                ///< the first tetrahedron

    std::size_t count(std::size_t elements) const {
        return elements * splitter.usual_count() + turned.size() * more();
    }
    /// Tetrahedra that the centre of an element adds.
    std::size_t more() const { return splitter.count_from_centre() - splitter.usual_count(); }
};

/// Adds the centres that are needed.
Share plan(ElementType type, const ElementBlock& block, const Order& order, std::size_t begin, int threads,
           std::vector<double>& points) {
    Share share{Splitter(type, order), {}, static_cast<NodeId>(points.size() / 3), begin};
    if (type != ElementType::kTetrahedron) share.turned = find_turned(points, block, share.splitter, threads);
    if (points.size() / 3 + share.turned.size() > std::numeric_limits<NodeId>::max())
        throw Error(ExitCode::kMeshing, "more than 2^32 nodes; choose larger cells");
    const std::size_t size = share.splitter.size();
    for (const std::size_t i : share.turned) {
        for (std::size_t j = 0; j < 3; ++j) {
            double sum = 0;
            for (std::size_t k = 0; k < size; ++k)
                sum += points[3 * std::size_t{block.nodes[i * size + k]} + j];
            points.push_back(sum / static_cast<double>(size));
        }
    }
    return share;
}

/// Splits the elements of one type into their share of the tetrahedra.
void split_block(const ElementBlock& block, const Share& share, const std::vector<double>& points,
                 int threads, ElementBlock& out) {
    const Splitter& splitter = share.splitter;
    parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        auto next = std::lower_bound(share.turned.begin(), share.turned.end(), begin);
        std::size_t to = share.begin + begin * splitter.usual_count() +
                         static_cast<std::size_t>(next - share.turned.begin()) * share.more();
        Pieces pieces;
        for (std::size_t i = begin; i < end; ++i) {
            const NodeId* const node = block.nodes.data() + i * splitter.size();
            if (next != share.turned.end() && *next == i) {
                const auto centre = static_cast<NodeId>(next++ - share.turned.begin());
                splitter.split_from(share.first_centre + centre, node, pieces);
                if (!all_positive(points, pieces)) {
                    throw Error(ExitCode::kMeshing, "element " + std::to_string(i) + " of " +
                                                        std::to_string(splitter.size()) +
                                                        " nodes cannot be split into positive tetrahedra; "
                                                        "use --elements hex");
                }
            } else {
                splitter.split(node, pieces);
            }
            for (std::size_t k = 0; k < pieces.count; ++k, ++to) {
                std::copy_n(pieces.list[k].begin(), 4,
                            out.nodes.begin() + static_cast<std::ptrdiff_t>(4 * to));
                out.region[to] = block.region[i];
                out.kind[to] = block.kind[i];
            }
        }
    });
}

/// Cuts quadrilaterals through their lowest nodes; the orientation stays.
FacetBlock split_facets(const FacetBlock& facets, const Order& order, int threads) {
    std::vector<FacetBlock> parts(chunk_count(facets.size(), kChunk));
    parallel_chunks(facets.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        FacetBlock& out = parts[begin / kChunk];
        for (std::size_t i = begin; i < end; ++i) {
            const FacetNodes node = facets.facet(i);
            const std::size_t count = node.size();
            std::array<std::uint64_t, 4> key{};
            for (std::size_t k = 0; k < 4; ++k) key[k] = order.key(node[k]);
            const std::size_t low = count == 4 ? lowest(key.data(), 4) : 0;
            for (std::size_t k = 1; k + 1 < count; ++k) {
                const NodeId last = node[(low + k + 1) % count];
                out.nodes.insert(out.nodes.end(), {node[low], node[(low + k) % count], last, last});
                out.surface.push_back(facets.surface[i]);
                out.inside.push_back(facets.inside[i]);
                out.outside.push_back(facets.outside[i]);
            }
        }
    });
    FacetBlock result;
    const auto gather = [&](auto member) {
        using List = std::remove_reference_t<decltype(result.*member)>;
        std::vector<List> lists;
        for (FacetBlock& part : parts) lists.push_back(std::move(part.*member));
        append_lists(lists, threads, result.*member);
    };
    gather(&FacetBlock::nodes);
    gather(&FacetBlock::surface);
    gather(&FacetBlock::inside);
    gather(&FacetBlock::outside);
    return result;
}

/// Which hexahedra split_around_cubes() splits: per element, not 0.
std::vector<std::uint8_t> find_split(const ElementBlock& hexahedra, const std::vector<NodeId>* rank,
                                     int threads) {
    std::vector<std::uint8_t> is_split(hexahedra.size());
    parallel_chunks(hexahedra.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const NodeId* const node = hexahedra.nodes.data() + kMostNodes * i;
            const bool is_ranked = rank != nullptr && std::any_of(node, node + kMostNodes, [&](NodeId n) {
                                       return n < rank->size() && (*rank)[n] != n;
                                   });
            is_split[i] = !is_cube(hexahedra, i) || is_ranked;
        }
    });
    return is_split;
}

/// The hexahedra of which `wanted` is set.
ElementBlock select(const ElementBlock& hexahedra, const std::vector<std::uint8_t>& wanted) {
    ElementBlock out;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (wanted[i] == 0) continue;
        const auto node = hexahedra.nodes.begin() + static_cast<std::ptrdiff_t>(kMostNodes * i);
        out.nodes.insert(out.nodes.end(), node, node + kMostNodes);
        out.region.push_back(hexahedra.region[i]);
        out.kind.push_back(hexahedra.kind[i]);
    }
    return out;
}

/// The pieces of a cube whose nodes ascend along the axes, as nearly all do.
class CubeSplitter {
  public:
    CubeSplitter() : order_(nullptr), any_(ElementType::kHexahedron, order_) {
        constexpr std::array<NodeId, kMostNodes> kAscending = {0, 1, 3, 2, 4, 5, 7, 6};
        Pieces pieces;
        any_.split(kAscending.data(), pieces);
        for (std::size_t k = 0; k < kPieceNodes; ++k) {
            const NodeId number = pieces.list[k / 4][k % 4];
            usual_[k] = static_cast<std::uint8_t>(std::find(kAscending.begin(), kAscending.end(), number) -
                                                  kAscending.begin());
        }
    }

    static constexpr std::size_t kPieces = 6;
    static constexpr std::size_t kPieceNodes = 4 * kPieces;

    /// Whether the pieces are sixths around a diagonal of the cube.
    bool split(const NodeId* n, NodeId* out) const {
        // The lowest node of the cube, and of the three faces that do not hold it, by steps along edges.
        const bool ascends = (n[0] < n[1]) & (n[0] < n[3]) & (n[0] < n[4]) & (n[1] < n[2]) & (n[1] < n[5]) &
                             (n[1] < n[6]) & (n[3] < n[2]) & (n[3] < n[7]) & (n[3] < n[6]) & (n[4] < n[5]) &
                             (n[4] < n[7]) & (n[4] < n[6]);
        if (ascends) {
            for (std::size_t k = 0; k < kPieceNodes; ++k) out[k] = n[usual_[k]];
            return true;
        }
        Pieces pieces;
        any_.split(n, pieces);
        for (std::size_t k = 0; k < kPieces; ++k) std::copy_n(pieces.list[k].begin(), 4, out + 4 * k);
        // The diagonals of the three faces end in one node: the one opposite the cone's apex.
        const NodeId end = pieces.list[0][1];
        return (pieces.list[1][2] == end) & (pieces.list[2][1] == end) & (pieces.list[3][2] == end) &
               (pieces.list[4][1] == end) & (pieces.list[5][2] == end);
    }

  private:
    Order order_;
    Splitter any_;
    std::array<std::uint8_t, kPieceNodes> usual_;
};

/// The runs of elements of which `is_one` is set, six tetrahedra for each, but for some elements.
IndexRuns sixths_of(const std::vector<std::uint8_t>& is_one, const IndexRuns& but) {
    IndexRuns runs;
    RunFinder left_out(but, 0);
    for (std::size_t i = 0; i < is_one.size(); ++i) {
        if (is_one[i] == 0 || left_out.run_of(i) != nullptr) continue;
        const std::size_t begin = CubeSplitter::kPieces * i;
        if (runs.empty() || runs.back().end != begin) runs.push_back({begin, begin});
        runs.back().end += CubeSplitter::kPieces;
    }
    return runs;
}

}  // namespace

Mesh split_around_cubes(Mesh mesh, int threads, const std::vector<NodeId>* rank, IndexRuns* followed) {
    const Order order(rank);
    std::array<ElementBlock, kElementTypes> whole;
    ElementBlock& hexahedra = mesh.elements[0];
    const std::vector<std::uint8_t> is_split = find_split(hexahedra, rank, threads);
    whole[0] = select(hexahedra, is_split);
    const Compaction cubes(is_split, threads);
    cubes.keep(hexahedra.nodes, kMostNodes);
    cubes.keep(hexahedra.region, 1);
    cubes.keep(hexahedra.kind, 1);
    if (followed != nullptr) *followed = without(*followed, is_split);
    std::vector<Share> shares;
    std::size_t count = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        if (t > 0) whole[t] = std::move(mesh.elements[t]);
        shares.push_back(plan(static_cast<ElementType>(t), whole[t], order, count, threads, mesh.points));
        count += shares.back().count(whole[t].size());
        if (t > 0) mesh.elements[t] = {};
    }
    ElementBlock& tetrahedra = mesh.block(ElementType::kTetrahedron);
    const std::size_t spare = count / 16;  // what is made better may be more
    resize_large(tetrahedra.nodes, 4 * count, threads, 4 * spare);
    resize_large(tetrahedra.region, count, threads, spare);
    resize_large(tetrahedra.kind, count, threads, spare);
    for (std::size_t t = 0; t < kElementTypes; ++t)
        split_block(whole[t], shares[t], mesh.points, threads, tetrahedra);
    mesh.facets = split_facets(mesh.facets, order, threads);
    return mesh;
}

Mesh split_cubes(Mesh mesh, int threads, const IndexRuns& moved, IndexRuns* sixths, Mesh* old) {
    constexpr std::size_t kPieces = CubeSplitter::kPieces;
    ElementBlock cubes = std::move(mesh.elements[0]);
    mesh.elements[0] = {};
    ElementBlock& others = mesh.block(ElementType::kTetrahedron);
    ElementBlock all;
    // Room for all, with the others behind the pieces.
    const auto make_room = [&](auto member, std::size_t stride) {
        const std::size_t first = stride * kPieces * cubes.size();
        const auto& values = others.*member;
        if (old != nullptr)
            take_memory(old->block(ElementType::kTetrahedron).*member, first + values.size(), all.*member);
        resize_large(all.*member, first + values.size(), threads);
        parallel_chunks(values.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            std::copy(&values[begin], &values[end], &(all.*member)[first + begin]);
        });
    };
    make_room(&ElementBlock::nodes, 4);
    make_room(&ElementBlock::region, 1);
    make_room(&ElementBlock::kind, 1);
    const CubeSplitter splitter;
    std::vector<std::uint8_t> is_alike(cubes.size());
    parallel_chunks(cubes.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            is_alike[i] = splitter.split(&cubes.nodes[kMostNodes * i], &all.nodes[4 * kPieces * i]);
            std::fill_n(&all.region[kPieces * i], kPieces, cubes.region[i]);
            std::fill_n(&all.kind[kPieces * i], kPieces, cubes.kind[i]);
        }
    });
    if (sixths != nullptr) *sixths = sixths_of(is_alike, moved);
    if (old != nullptr) old->elements[0] = std::move(cubes);
    mesh.block(ElementType::kTetrahedron) = std::move(all);
    return mesh;
}

}  // namespace mortise::tetrahedra
