#include "host/hanging/restore.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "host/common/cube_grid.hpp"
#include "host/common/element_block.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"

namespace mortise::hanging {
namespace {

constexpr std::size_t kChunk = 8192;
constexpr NodeId kNoNode = std::numeric_limits<NodeId>::max();
constexpr std::size_t kNoCell = ~std::size_t{0};
/// Vertices of the cube in halves that are its corners, in the order of a hexahedron's nodes.
constexpr std::array<std::uint8_t, 8> kCorners = {0, 2, 8, 6, 18, 20, 26, 24};

/// A set of the 27 vertices of the cube in halves.
using VertexSet = std::uint32_t;
constexpr VertexSet bit_of(std::uint8_t vertex) { return VertexSet{1} << vertex; }

/// A side of the cube, its vertices as sets.
struct Side {
    VertexSet all = 0;
    VertexSet corners = 0;
    std::array<VertexSet, 4> quarters{};
};

std::array<Side, 6> make_sides() {
    std::array<Side, 6> sides;
    for (std::size_t f = 0; f < 6; ++f) {
        const std::size_t axis = f / 2, u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        for (int a = 0; a < 9; ++a) {
            GridPoint p{};
            p[axis] = 2 * static_cast<int>(f & 1);
            p[u] = a % 3;
            p[v] = a / 3;
            const VertexSet vertex = bit_of(grid_vertex(p));
            sides[f].all |= vertex;
            if (p[u] != 1 && p[v] != 1) sides[f].corners |= vertex;
            for (int q = 0; q < 4; ++q) {
                const int low_u = q & 1, low_v = q >> 1;
                if (p[u] >= low_u && p[u] <= low_u + 1 && p[v] >= low_v && p[v] <= low_v + 1)
                    sides[f].quarters[static_cast<std::size_t>(q)] |= vertex;
            }
        }
    }
    return sides;
}

/// An element of a template between cells of different sizes.
struct Member {
    std::size_t leaf;
    std::uint32_t index;
    std::uint8_t type;

    bool operator<(const Member& other) const {
        if (leaf != other.leaf) return leaf < other.leaf;
        return type != other.type ? type < other.type : index < other.index;
    }
};

/// A leaf with its template.
struct Cell {
    std::size_t leaf = 0;
    std::size_t first = 0, last = 0;           ///< its members
    std::array<NodeId, kGridVertices> node{};  ///< by vertex; kNoNode: none
    std::uint8_t divided = 0;                  ///< bit f: side f is no quadrilateral, nor four quarters
    std::uint16_t region = 0;
    bool fits = false;
};

class Restorer {
  public:
    Restorer(Mesh mesh, const Frame& frame, int threads)
        : mesh_(std::move(mesh)), frame_(frame), grid_(*frame.leaves), threads_(threads) {}

    Restored run() {
        find_members();
        find_cells();
        drop_unmatched();
        const auto restored = static_cast<std::uint64_t>(
            std::count_if(cells_.begin(), cells_.end(), [](const Cell& cell) { return cell.fits; }));
        if (restored > 0) {
            replace_elements();
            list_hanging_nodes();
            drop_unused_nodes();
        }
        return {std::move(mesh_), restored};
    }

  private:
    const double* point(NodeId node) const { return mesh_.points.data() + 3 * std::size_t{node}; }

    const NodeId* nodes_of(const Member& member) const {
        const auto count = static_cast<std::size_t>(kElementNodes[member.type]);
        return mesh_.elements[member.type].nodes.data() + count * member.index;
    }

    std::size_t leaf_of(const NodeId* node, int count) const {
        const double per_cell = std::ldexp(1.0, grid_.level) / frame_.side;
        std::array<double, 3> at{};
        for (std::size_t j = 0; j < 3; ++j) {
            for (int k = 0; k < count; ++k) at[j] += point(node[k])[j];
            at[j] = (at[j] / count - frame_.origin[j]) * per_cell;
        }
        return find_leaf(grid_, finest_cell(grid_, at));
    }

    void find_members() {
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const ElementBlock& block = mesh_.elements[t];
            const int count = kElementNodes[t];
            std::vector<std::vector<Member>> found(chunk_count(block.size(), kChunk));
            parallel_chunks(block.size(), kChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) {
                    if (block.kind[i] != static_cast<std::uint8_t>(ElementKind::kTransition)) continue;
                    const NodeId* node = block.nodes.data() + i * static_cast<std::size_t>(count);
                    const std::size_t leaf = leaf_of(node, count);
                    if (leaf == kNoLeaf) continue;
                    found[begin / kChunk].push_back(
                        {leaf, static_cast<std::uint32_t>(i), static_cast<std::uint8_t>(t)});
                }
            });
            append_lists(found, threads_, members_);
        }
        parallel_sort(members_, threads_);
    }

    void find_cells() {
        for (std::size_t i = 0; i < members_.size(); ++i) {
            if (cells_.empty() || cells_.back().leaf != members_[i].leaf) {
                cells_.emplace_back();
                cells_.back().leaf = members_[i].leaf;
                cells_.back().first = i;
            }
            cells_.back().last = i + 1;
        }
        parallel_chunks(cells_.size(), kChunk / 16, threads_, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) cells_[i].fits = find_sides(cells_[i]);
        });
    }

    /// Vertex of a leaf's cube at which a node lies to the last bit, or kGridVertices.
    std::uint8_t vertex_at(const GridCube& cube, NodeId node) const {
        const double half = 0.5 * edge_of(cube.size_class);
        const double finest = std::ldexp(1.0, -grid_.level);
        GridPoint at{};
        for (std::size_t j = 0; j < 3; ++j) {
            const auto low = static_cast<double>(cube.low()[j]);
            const double local = (point(node)[j] - frame_.origin[j]) / (frame_.side * finest) - low;
            at[j] = static_cast<int>(std::clamp(std::nearbyint(local / half), 0.0, 2.0));
            const double expected = frame_.origin[j] + frame_.side * ((low + at[j] * half) * finest);
            if (point(node)[j] != expected) return kGridVertices;
        }
        return grid_vertex(at);
    }

    /// Nodes and sides of a cell. False if its elements are not those of a template any more: then they have
    /// nodes elsewhere, or do not fill the cube.
    bool find_sides(Cell& cell) const {
        static const std::array<Side, 6> sides = make_sides();
        const GridCube cube = cube_of(grid_, cell.leaf);
        cell.node.fill(kNoNode);
        cell.region = mesh_.elements[members_[cell.first].type].region[members_[cell.first].index];
        std::vector<VertexSet> faces;
        for (std::size_t i = cell.first; i < cell.last; ++i) {
            const Member& member = members_[i];
            if (mesh_.elements[member.type].region[member.index] != cell.region) return false;
            const NodeId* node = nodes_of(member);
            std::array<std::uint8_t, 8> vertex{};
            for (int k = 0; k < kElementNodes[member.type]; ++k) {
                const std::uint8_t at = vertex_at(cube, node[k]);
                if (at == kGridVertices) return false;
                cell.node[at] = node[k];
                vertex[static_cast<std::size_t>(k)] = at;
            }
            const LocalFaces local = local_faces(static_cast<ElementType>(member.type));
            for (int f = 0; f < local.count; ++f) {
                VertexSet face = 0;
                for (const int k : local.faces[f]) {
                    if (k >= 0) face |= bit_of(vertex[static_cast<std::size_t>(k)]);
                }
                faces.push_back(face);
            }
        }
        std::sort(faces.begin(), faces.end());
        std::array<int, 6> whole{}, quarters{}, others{};
        for (std::size_t i = 0; i < faces.size(); ++i) {
            if (i + 1 < faces.size() && faces[i] == faces[i + 1]) {  // between two of the elements
                ++i;
                continue;
            }
            const auto side = static_cast<std::size_t>(
                std::find_if(sides.begin(), sides.end(),
                             [&](const Side& s) { return (faces[i] & ~s.all) == 0; }) -
                sides.begin());
            // If all outer faces lie on the cube's sides, the elements fill it.
            if (side == sides.size()) return false;
            const auto& quarter = sides[side].quarters;
            if (faces[i] == sides[side].corners)
                ++whole[side];
            else if (std::find(quarter.begin(), quarter.end(), faces[i]) != quarter.end())
                ++quarters[side];
            else
                ++others[side];
        }
        for (std::size_t f = 0; f < 6; ++f) {
            if (whole[f] == 0 && (quarters[f] != 4 || others[f] != 0))
                cell.divided |= static_cast<std::uint8_t>(1u << f);
        }
        return true;
    }

    /// The cell of the same size beyond side f, or kNoCell.
    std::size_t cell_beside(const Cell& cell, int f) const {
        const GridCube cube = cube_of(grid_, cell.leaf);
        std::array<std::int64_t, 3> low = cube.low();
        low[static_cast<std::size_t>(f / 2)] +=
            ((f & 1) != 0 ? 1 : -1) * (std::int64_t{1} << cube.size_class);
        const std::int64_t end = std::int64_t{1} << grid_.level;
        if (*std::min_element(low.begin(), low.end()) < 0 || *std::max_element(low.begin(), low.end()) >= end)
            return kNoCell;
        const std::uint64_t code =
            morton_encode(static_cast<std::uint32_t>(low[0]), static_cast<std::uint32_t>(low[1]),
                          static_cast<std::uint32_t>(low[2]));
        const std::size_t leaf = find_leaf(grid_, code);
        if (leaf == kNoLeaf || grid_.size_class(leaf) != cube.size_class) return kNoCell;
        const auto found = std::lower_bound(cells_.begin(), cells_.end(), leaf,
                                            [](const Cell& c, std::size_t l) { return c.leaf < l; });
        if (found == cells_.end() || found->leaf != leaf) return kNoCell;
        return static_cast<std::size_t>(found - cells_.begin());
    }

    /// A divided side needs a partner that is taken back, too; whoever loses its partner is dropped, so the
    /// largest set of cells is left, in whatever order.
    void drop_unmatched() {
        const auto is_divided = [](const Cell& cell, int f) { return ((cell.divided >> f) & 1) != 0; };
        std::vector<std::size_t> open;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            bool keeps = cells_[i].fits;
            for (int f = 0; f < 6 && keeps; ++f) {
                if (!is_divided(cells_[i], f)) continue;
                const std::size_t other = cell_beside(cells_[i], f);
                keeps = other != kNoCell && cells_[other].fits;
            }
            if (!keeps) open.push_back(i);
        }
        for (const std::size_t i : open) cells_[i].fits = false;
        while (!open.empty()) {
            const std::size_t i = open.back();
            open.pop_back();
            for (int f = 0; f < 6; ++f) {
                const std::size_t other = cell_beside(cells_[i], f);
                if (other == kNoCell || !cells_[other].fits || !is_divided(cells_[other], f ^ 1)) continue;
                cells_[other].fits = false;
                open.push_back(other);
            }
        }
    }

    void replace_elements() {
        std::array<std::vector<std::uint8_t>, kElementTypes> gone;
        for (std::size_t t = 0; t < kElementTypes; ++t) gone[t].assign(mesh_.elements[t].size(), 0);
        for (const Cell& cell : cells_) {
            if (!cell.fits) continue;
            for (std::size_t i = cell.first; i < cell.last; ++i)
                gone[members_[i].type][members_[i].index] = 1;
        }
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            keep_elements(mesh_.elements[t], static_cast<std::size_t>(kElementNodes[t]),
                          [&](std::size_t i) { return gone[t][i] == 0; });
        }
        ElementBlock& hexahedra = mesh_.block(ElementType::kHexahedron);
        for (const Cell& cell : cells_) {
            if (!cell.fits) continue;
            for (const std::uint8_t corner : kCorners) hexahedra.nodes.push_back(cell.node[corner]);
            hexahedra.region.push_back(cell.region);
            hexahedra.kind.push_back(static_cast<std::uint8_t>(ElementKind::kTransition));
        }
    }

    void list_hanging_nodes() {
        struct Hanging {
            NodeId node;
            std::array<NodeId, 4> masters;
        };
        std::vector<Hanging> found;
        for (const Cell& cell : cells_) {
            if (!cell.fits) continue;
            for (int e = 0; e < 12; ++e) {
                const NodeId node = cell.node[edge_middle(e)];
                if (node == kNoNode) continue;
                GridPoint low = grid_point(edge_middle(e)), high = low;
                low[static_cast<std::size_t>(e / 4)] = 0;
                high[static_cast<std::size_t>(e / 4)] = 2;
                NodeId a = cell.node[grid_vertex(low)], b = cell.node[grid_vertex(high)];
                if (a > b) std::swap(a, b);
                found.push_back({node, {a, b, a, b}});
            }
            for (const LocalFace& face : kHexahedronFaces) {
                GridPoint centre{};
                std::array<NodeId, 4> masters{};
                for (std::size_t k = 0; k < 4; ++k) {
                    const std::uint8_t corner = kCorners[static_cast<std::size_t>(face[k])];
                    for (std::size_t j = 0; j < 3; ++j) centre[j] += grid_point(corner)[j];
                    masters[k] = cell.node[corner];
                }
                for (int& x : centre) x /= 4;
                const NodeId node = cell.node[grid_vertex(centre)];
                if (node != kNoNode) found.push_back({node, masters});
            }
        }
        std::sort(found.begin(), found.end(),
                  [](const Hanging& a, const Hanging& b) { return a.node < b.node; });
        HangingNodes& hanging = mesh_.hanging;
        for (const Hanging& one : found) {  // the cells around an edge say the same of its middle
            if (!hanging.node.empty() && hanging.node.back() == one.node) continue;
            hanging.node.push_back(one.node);
            hanging.masters.insert(hanging.masters.end(), one.masters.begin(), one.masters.end());
        }
    }

    /// Nodes of templates alone, as in the middle of a cell.
    void drop_unused_nodes() {
        std::vector<std::uint8_t> used(mesh_.node_count(), 1);
        for (const Cell& cell : cells_) {
            if (!cell.fits) continue;
            for (const NodeId node : cell.node) {
                if (node != kNoNode) used[node] = 0;
            }
        }
        for (const ElementBlock& block : mesh_.elements) {
            for (const NodeId node : block.nodes) used[node] = 1;
        }
        std::vector<NodeId> number(used.size(), kNoNode);
        NodeId kept = 0;
        for (std::size_t i = 0; i < used.size(); ++i) {
            if (used[i] == 0) continue;
            std::copy_n(point(static_cast<NodeId>(i)), 3, mesh_.points.data() + 3 * std::size_t{kept});
            number[i] = kept++;
        }
        mesh_.points.resize(3 * std::size_t{kept});
        const auto renumber = [&](std::vector<NodeId>& nodes) {
            parallel_chunks(nodes.size(), kChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) nodes[i] = number[nodes[i]];
            });
        };
        for (ElementBlock& block : mesh_.elements) renumber(block.nodes);
        renumber(mesh_.facets.nodes);
        renumber(mesh_.hanging.node);
        renumber(mesh_.hanging.masters);
    }

    Mesh mesh_;
    const Frame& frame_;
    const LeafGrid& grid_;
    int threads_;
    std::vector<Member> members_;
    std::vector<Cell> cells_;
};

}  // namespace

Restored restore_cells(Mesh mesh, const Frame& frame, int threads) {
    if (frame.leaves == nullptr || frame.leaves->is_uniform()) return {std::move(mesh), 0};
    return Restorer(std::move(mesh), frame, threads).run();
}

}  // namespace mortise::hanging
