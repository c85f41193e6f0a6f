#include "host/triangles/divide.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/common/parallel.hpp"
#include "host/tape/reference.hpp"
#include "host/triangles/cell_formula.hpp"
#include "kernels/shared/spatial.h"
#include "mortise/error.hpp"

namespace mortise::triangles {
namespace {

// Above the finest level a cell becomes a formula if it has few faces and the formula is short: what the
// descent prunes costs its length.
constexpr std::size_t kFewFaces = 6;
constexpr std::size_t kShortFormula = 24;
constexpr std::size_t kFewInLeaf = 3;   ///< in a leaf that could be split
constexpr std::size_t kMostFaces = 16;  ///< in a finest cell
// A cell's formula holds a little beyond the cell, in finest cells. Then neighbours know the same surfaces
// where two of these cross close to their common edge, and what each makes of the edge agrees: three-valued
// logic cannot tell such an edge from one that the solid touches, so it must not be left to one side.
constexpr double kMargin = 0.5;
// A surface this close to a cell, in cells, is not off it: far above kSignTolerance.
constexpr double kTouching = 1.0 / 1024;
// Where a formula is compared with the solid: this far from the middle along each axis, in cells.
constexpr double kProbed = 0.4;
constexpr double kCertain = 0.05;  ///< winding numbers this far from whole ones are those of open surfaces
constexpr double kNoArea = 1e-12;  ///< of a cell's face: smaller pieces of triangles are left out
constexpr std::size_t kChunk = 16;

struct Node {
    std::array<std::uint32_t, 3> at{};  ///< integer coordinates at its level
    std::vector<std::uint32_t> triangles;
};

/// What becomes of one child.
struct Entry {
    enum class Kind : std::uint8_t { kConstant, kFormula, kNode };
    Kind kind = Kind::kConstant;
    bool solid = false;
    bool empty = false;                ///< of triangles
    std::vector<std::uint32_t> words;  ///< kFormula: tape; kNode: triangles
    bool crowded = false;
};

class Divider {
  public:
    Divider(const tape::BoundModel& model, const tape::BoundPolyhedron& polyhedron, int base, int level,
            int threads)
        : model_(model),
          polyhedron_(polyhedron),
          winding_(polyhedron.shape),
          base_(base),
          level_(level),
          threads_(threads) {}

    /// Appends the octree to the table; returns the place of its root.
    std::uint32_t run(std::vector<std::uint32_t>& table, Division& division) {
        std::vector<Node> nodes(1);
        for (std::uint32_t t = 0; t < polyhedron_.shape.triangles.size(); ++t)
            nodes[0].triangles.push_back(t);
        const std::uint32_t root = append(table, 8);
        std::uint32_t place = root;  // of the level's first node; the others follow
        for (int level = 1; level <= level_ && !nodes.empty(); ++level) {
            std::vector<Entry> entries(8 * nodes.size());
            parallel_chunks(nodes.size(), kChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                CellFormula formula(model_, winding_);
                std::vector<Polygon> pieces;
                for (std::size_t i = begin; i < end; ++i) {
                    Entry* children = entries.data() + 8 * i;
                    for (std::uint32_t c = 0; c < 8; ++c) {
                        make_entry(nodes[i], c, level, formula, pieces, children);
                    }
                }
            });
            division.nodes += nodes.size();
            std::vector<Node> next;
            for (std::size_t i = 0; i < entries.size(); ++i) {
                if (entries[i].kind != Entry::Kind::kNode) continue;
                next.push_back(
                    {child_of(nodes[i / 8], static_cast<std::uint32_t>(i % 8)), std::move(entries[i].words)});
            }
            const std::uint32_t children = append(table, 8 * next.size());
            std::uint32_t node = children;
            for (std::size_t i = 0; i < entries.size(); ++i) {
                std::uint32_t& entry = table[place + i];
                if (entries[i].kind == Entry::Kind::kConstant) {
                    entry = entries[i].solid ? kSpatialIn : kSpatialOut;
                } else if (entries[i].kind == Entry::Kind::kNode) {
                    entry = node;
                    node += 8;
                } else {
                    ++division.formulas;
                    division.crowded += entries[i].crowded ? 1 : 0;
                    const auto& words = entries[i].words;
                    const std::uint32_t at = append(table, 1 + words.size());
                    table[at] = static_cast<std::uint32_t>(words.size());
                    std::copy(words.begin(), words.end(), table.begin() + at + 1);
                    table[place + i] = kSpatialFormula | at;
                }
            }
            place = children;
            nodes = std::move(next);
        }
        return root;
    }

  private:
    static std::uint32_t append(std::vector<std::uint32_t>& table, std::size_t words) {
        const std::size_t place = table.size();
        if (place + words > 0x0fffffffU) {
            throw Error(
                ExitCode::kMeshing,
                "the triangles of the model need a table of more than 2^28 words; use a lower --level");
        }
        table.resize(place + words);
        return static_cast<std::uint32_t>(place);
    }

    static std::array<std::uint32_t, 3> child_of(const Node& node, std::uint32_t c) {
        return {2 * node.at[0] + (c & 1), 2 * node.at[1] + ((c >> 1) & 1), 2 * node.at[2] + (c >> 2)};
    }

    /// Makes entry c of a node; those before it are there.
    void make_entry(const Node& node, std::uint32_t c, int level, CellFormula& formula,
                    std::vector<Polygon>& pieces, Entry* entries) const {
        Entry& entry = entries[c];
        const auto at = child_of(node, c);
        const double size = std::ldexp(1.0, -level);
        glm::dvec3 centre;
        for (int j = 0; j < 3; ++j) centre[j] = (at[static_cast<std::size_t>(j)] + 0.5) * size;
        // Of the largest leaf that the formula may serve.
        const double half = 0.5 * size + kMargin * std::ldexp(1.0, -std::max(level, base_));
        std::vector<std::uint32_t> inside;
        cut_triangles(node.triangles, centre, half, pieces, inside);
        if (pieces.empty()) {
            // Two empty cells with a common face lie on the same side.
            entry.empty = true;
            for (std::uint32_t axis = 1; axis < 8; axis <<= 1) {
                if ((c & axis) == 0 || !entries[c ^ axis].empty) continue;
                entry.solid = entries[c ^ axis].solid;
                return;
            }
            entry.solid = winding_.is_inside(centre);
            return;
        }
        const bool finest = level == level_;
        std::size_t faces = count_faces(pieces, kFewFaces + 1);
        // A cell that may be a leaf. Patches are bounded by nothing but the cell: they stay with such.
        const bool leaf = finest || (level >= base_ && faces <= kFewInLeaf);
        if (leaf || (faces <= kFewFaces && all_flat(pieces))) {
            if (finest && faces > kFewFaces) faces = count_faces(pieces, kMostFaces + 1);
            if (faces > kMostFaces) {
                entry.crowded = true;
                keep_largest(pieces, kMostFaces);
            }
            formula.make(pieces, centre, size);
            for (std::size_t most = kMostFaces / 2; finest && formula.stack() > kSpatialStack; most /= 2) {
                entry.crowded = true;
                keep_largest(pieces, most);
                formula.make(pieces, centre, size);
            }
            if (formula.is_constant()) {
                entry.solid = formula.value();
                return;
            }
            if (leaf && !entry.crowded && holds_patch(pieces) &&
                !reach_cube(pieces, centre, (0.5 + kTouching) * size)) {
                const double winding = winding_.at(centre);
                const bool solid = winding > 0.5;
                const bool is_certain = std::fabs(winding - std::round(winding)) < kCertain;
                if (is_certain && differs(formula.words(), centre, size, solid)) {
                    entry.solid = solid;
                    return;
                }
            }
            if (leaf && formula.stack() <= kSpatialStack) {
                prune(formula.words(), {{centre[0], centre[1], centre[2]}, (0.5 + kTouching) * size}, entry);
                return;
            }
            if (formula.words().size() <= kShortFormula && formula.stack() <= kSpatialStack) {
                entry.kind = Entry::Kind::kFormula;
                entry.words = formula.words();
                return;
            }
        }
        entry.kind = Entry::Kind::kNode;
        entry.words = std::move(inside);
    }

    /// What is left of a formula in the closed cell; above the finest level the descent does this.
    void prune(const std::vector<std::uint32_t>& words, const tape::Cell& cell, Entry& entry) const {
        std::vector<std::int32_t> states;
        for (const std::uint32_t word : words) {
            int sign = 0;
            if (tape_operation(word) == kTapeLiteral) {
                const std::uint32_t surface = tape_surface(word);
                sign = model_.surfaces[surface].kind == kSurfacePatch
                           ? patch_side(surface, cell)
                           : tape::classify_surface(model_, surface, cell);
            }
            states.push_back(sign == 0 ? kUnknown : (sign < 0) != (tape_negated(word) != 0) ? 1 : 0);
        }
        const std::int32_t value = tape::prune(words, states, &entry.words);
        entry.solid = value == 1;
        if (value == kUnknown) entry.kind = Entry::Kind::kFormula;
    }

    /// Side of a patch that the cell lies on, 0: perhaps both. Patches are distances.
    int patch_side(std::uint32_t surface, const tape::Cell& cell) const {
        const Surface& s = model_.surfaces[surface];
        const double value =
            surface_value(&s, model_.expression_ops.data(), cell.centre[0], cell.centre[1], cell.centre[2]);
        const double unit = std::sqrt(s.map[0] * s.map[0] + s.map[1] * s.map[1] + s.map[2] * s.map[2]);
        const double reach = 1.7321 * cell.half * unit;
        return value > reach ? 1 : value < -reach ? -1 : 0;
    }

    /// The triangles' parts in a cube, and which triangles have one.
    void cut_triangles(const std::vector<std::uint32_t>& triangles, const glm::dvec3& centre, double half,
                       std::vector<Polygon>& pieces, std::vector<std::uint32_t>& inside) const {
        pieces.clear();
        for (const std::uint32_t t : triangles) {
            Polygon triangle;
            triangle.count = 3;
            triangle.surface = polyhedron_.surface[t];
            glm::dvec3 low(1e300);
            glm::dvec3 high(-1e300);
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3& p = polyhedron_.shape.points[polyhedron_.shape.triangles[t][k]];
                triangle.corner[k] = {p[0], p[1], p[2]};
                low = glm::min(low, triangle.corner[k]);
                high = glm::max(high, triangle.corner[k]);
            }
            bool apart = false;
            for (int j = 0; j < 3; ++j) {
                apart = apart || low[j] > centre[j] + half || high[j] < centre[j] - half;
            }
            if (apart) continue;
            const Polygon piece = clip_to_cube(triangle, centre, half);
            if (piece.count < 3 || piece.area() < kNoArea * half * half) continue;
            pieces.push_back(piece);
            inside.push_back(t);
        }
    }

    /// Whether a piece reaches into a cube.
    static bool reach_cube(const std::vector<Polygon>& pieces, const glm::dvec3& centre, double half) {
        return std::any_of(pieces.begin(), pieces.end(), [&](const Polygon& piece) {
            return clip_to_cube(piece, centre, half).count >= 3;
        });
    }

    bool holds_patch(const std::vector<Polygon>& pieces) const {
        return std::any_of(pieces.begin(), pieces.end(), [this](const Polygon& piece) {
            return model_.surfaces[piece.surface].kind == kSurfacePatch;
        });
    }

    /// Whether a formula is wrong somewhere in a cell without triangles, which is `solid` or not. Beyond its
    /// rim a patch goes on, so one that only comes close to a corner may come back into the cell.
    bool differs(const std::vector<std::uint32_t>& words, const glm::dvec3& centre, double size,
                 bool solid) const {
        std::vector<std::int32_t> states(words.size(), 0);
        for (int i = 0; i < 27; ++i) {
            const glm::dvec3 x = centre + kProbed * size * glm::dvec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            for (std::size_t w = 0; w < words.size(); ++w) {
                if (tape_operation(words[w]) != kTapeLiteral) continue;
                const double value = surface_value(&model_.surfaces[tape_surface(words[w])],
                                                   model_.expression_ops.data(), x.x, x.y, x.z);
                states[w] = (value < 0) != (tape_negated(words[w]) != 0) ? 1 : 0;
            }
            if ((tape::prune(words, states, nullptr) == 1) != solid) return true;
        }
        return false;
    }

    bool all_flat(const std::vector<Polygon>& pieces) const {
        return std::all_of(pieces.begin(), pieces.end(), [this](const Polygon& piece) {
            return model_.surfaces[piece.surface].kind == kSurfacePlane;
        });
    }

    /// Number of different surfaces, up to `most`.
    static std::size_t count_faces(const std::vector<Polygon>& pieces, std::size_t most) {
        std::vector<std::uint32_t> seen;
        for (const Polygon& piece : pieces) {
            if (std::find(seen.begin(), seen.end(), piece.surface) != seen.end()) continue;
            seen.push_back(piece.surface);
            if (seen.size() == most) break;
        }
        return seen.size();
    }

    /// Keeps the pieces of the `most` surfaces that have the largest areas here.
    static void keep_largest(std::vector<Polygon>& pieces, std::size_t most) {
        std::map<std::uint32_t, double> area;
        for (const Polygon& piece : pieces) area[piece.surface] += piece.area();
        std::vector<std::pair<double, std::uint32_t>> order;
        for (const auto& [surface, size] : area) order.emplace_back(-size, surface);
        std::sort(order.begin(), order.end());
        order.resize(std::min(order.size(), std::max<std::size_t>(most, 1)));
        const auto is_small = [&order](const Polygon& piece) {
            return std::none_of(order.begin(), order.end(),
                                [&piece](const auto& kept) { return kept.second == piece.surface; });
        };
        pieces.erase(std::remove_if(pieces.begin(), pieces.end(), is_small), pieces.end());
    }

    const tape::BoundModel& model_;
    const tape::BoundPolyhedron& polyhedron_;
    WindingNumber winding_;
    int base_;
    int level_;
    int threads_;
};

}  // namespace

Division divide(tape::BoundModel& model, int base, int finest, int threads) {
    Division division;
    model.spatial.assign(8, 0);  // places 0 and 1 mean OUT and IN
    std::vector<std::uint32_t> roots;
    for (const tape::BoundPolyhedron& polyhedron : model.polyhedra) {
        roots.push_back(Divider(model, polyhedron, base, finest, threads).run(model.spatial, division));
    }
    for (std::uint32_t& word : model.tape) {
        if (tape_operation(word) == kTapeSpatial)
            word = make_spatial(roots[tape_surface(word)], tape_negated(word));
    }
    return division;
}

}  // namespace mortise::triangles
