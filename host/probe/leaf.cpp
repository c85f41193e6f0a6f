#include "host/probe/leaf.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/watch.hpp"
#include "host/tape/variation.hpp"
#include "kernels/shared/surface.h"

namespace mortise::probe {
namespace {

/// Neighbour of a piece across its face f, or kPieces beyond the leaf.
std::uint32_t neighbour(std::uint32_t piece, int f) {
    const std::uint32_t shift = static_cast<std::uint32_t>(kDepth * (f / 2));
    const std::uint32_t at = (piece >> shift) & (kSide - 1);
    if (at == ((f & 1) != 0 ? kSide - 1u : 0u)) return kPieces;
    return (f & 1) != 0 ? piece + (1u << shift) : piece - (1u << shift);
}

}  // namespace

tape::Cell LeafProbe::cell(const std::uint8_t* at, int depth) const {
    const double edge = std::ldexp(edge_, -depth);
    tape::Cell result{};
    for (int j = 0; j < 3; ++j) result.centre[j] = low_[j] + (at[j] + 0.5) * edge;
    result.half = 0.5 * edge;
    return result;
}

Vec3 LeafProbe::centre(std::uint32_t piece) const {
    const std::uint8_t at[3] = {static_cast<std::uint8_t>(piece % kSide),
                                static_cast<std::uint8_t>(piece / kSide % kSide),
                                static_cast<std::uint8_t>(piece / (kSide * kSide))};
    const tape::Cell c = cell(at, kDepth);
    return {c.centre[0], c.centre[1], c.centre[2]};
}

/// The one sign of a surface at the leaf's samples, 0 if there are two or none.
std::int8_t LeafProbe::sample_sign(std::uint32_t surface) const {
    bool negative = false;
    bool positive = false;
    for (int k = 0; k < 27; ++k) {
        const int d[3] = {k % 3, k / 3 % 3, k / 9};
        const int middles = (d[0] == 1) + (d[1] == 1) + (d[2] == 1);
        if (middles == 1) continue;  // the middle of an edge is no sample
        double x[3];
        for (int j = 0; j < 3; ++j) x[j] = low_[j] + 0.5 * d[j] * edge_;
        const int sign =
            surface_sign(&model_.surfaces[surface], model_.expression_ops.data(), x[0], x[1], x[2], edge_);
        negative = negative || sign < 0;
        positive = positive || sign > 0;
        if (negative && positive) return 0;
    }
    return static_cast<std::int8_t>(positive ? 1 : negative ? -1 : 0);
}

void LeafProbe::load_tape(const TreeNode& leaf) {
    const std::uint32_t* words = tree_.tapes.data() + leaf.tape_offset;
    tape::list_surfaces(words, leaf.tape_length, surfaces_);
    local_tape_.load(words, leaf.tape_length, surfaces_);
}

Vec3 LeafProbe::middle_of(const TreeNode& leaf) const {
    const double half = 0.5 * octree::Octree::edge_of(tree_.level_of(leaf.morton));
    Vec3 x{};
    for (std::size_t j = 0; j < 3; ++j) x[j] = gather_bits(leaf.morton >> j) * tree_.finest_edge() + half;
    return x;
}

/// The surfaces of a leaf's tape that may hide something; equal ones in a row count once.
LeafProbe::Curved LeafProbe::curved_surfaces(const TreeNode& leaf) const {
    const std::uint32_t* words = tree_.tapes.data() + leaf.tape_offset;
    Curved curved;
    for (std::uint32_t i = 0; i < leaf.tape_length; ++i) {
        const std::uint32_t surface = tape_surface(words[i]);
        if (tape_operation(words[i]) != kTapeLiteral || (curved.count > 0 && surface == curved.last))
            continue;
        if (cannot_hide(surface)) continue;
        curved.last = surface;
        ++curved.count;
    }
    return curved;
}

/// Formulas alone in their leaves take most of a probe's time, and are asked in lanes.
void LeafProbe::prepare_batch(std::uint32_t begin, std::uint32_t end) {
    first_seen_ = begin;
    steady_.assign(end - begin, std::int8_t{-1});
    struct Sole {
        std::uint32_t surface;
        int level;
        std::uint32_t leaf;
    };
    std::vector<Sole> list;
    for (std::uint32_t i = begin; i < end; ++i) {
        const TreeNode& leaf = tree_.nio[i];
        const Curved curved = curved_surfaces(leaf);
        if (curved.count == 1 && model_.surfaces[curved.last].kind == kSurfaceExpression)
            list.push_back({curved.last, tree_.level_of(leaf.morton), i});
    }
    std::stable_sort(list.begin(), list.end(), [](const Sole& a, const Sole& b) {
        return a.surface != b.surface ? a.surface < b.surface : a.level < b.level;
    });
    std::vector<Vec3> centres;
    std::vector<std::uint8_t> steady;
    for (std::size_t i = 0; i < list.size();) {
        const std::size_t first = i;
        const double edge = octree::Octree::edge_of(list[first].level);
        centres.clear();
        for (;
             i < list.size() && list[i].surface == list[first].surface && list[i].level == list[first].level;
             ++i) {
            centres.push_back(middle_of(tree_.nio[list[i].leaf]));
        }
        batch_.find_steady(list[first].surface, centres, 0.5 * edge, steady);
        for (std::size_t k = first; k < i; ++k)
            steady_[list[k].leaf - begin] = static_cast<std::int8_t>(steady[k - first]);
    }
}

bool LeafProbe::is_steady(std::uint32_t index, std::uint32_t surface, const tape::Cell& whole) const {
    const std::size_t at = index - first_seen_;
    if (index >= first_seen_ && at < steady_.size() && steady_[at] >= 0) return steady_[at] != 0;
    return tape::has_small_variation(model_, surface, whole);
}

/// Finds the hidden surfaces, and the winding ones; false if none of the hidden ones may hide a feature.
bool LeafProbe::load(std::uint32_t index) {
    const TreeNode& leaf = tree_.nio[index];
    winding_.clear();
    folds_ = false;
    if (leaf.tape_length == 0) return false;  // an IN leaf among the others
    edge_ = octree::Octree::edge_of(tree_.level_of(leaf.morton));
    for (int j = 0; j < 3; ++j) low_[j] = gather_bits(leaf.morton >> j) * tree_.finest_edge();
    const std::uint8_t origin[3] = {0, 0, 0};
    const tape::Cell whole = cell(origin, 0);
    // One smooth surface alone, by far the most frequent, is asked before anything is set up.
    const Curved curved = curved_surfaces(leaf);
    if (curved.count == 0 || (curved.count == 1 && is_steady(index, curved.last, whole))) return false;
    load_tape(leaf);
    hidden_.clear();
    hidden_sign_.clear();
    bool steady = true;
    for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
        if (cannot_hide(surfaces_[s])) continue;
        if (tape::classify_surface(model_, surfaces_[s], whole) != 0) continue;
        const std::int8_t sign = sample_sign(surfaces_[s]);
        if (sign == 0) {
            if (!tape::has_small_variation(model_, surfaces_[s], whole)) winding_.push_back(s);
            continue;
        }
        steady = steady && tape::has_small_variation(model_, surfaces_[s], whole);
        hidden_.push_back(s);
        hidden_sign_.push_back(sign);
    }
    folds_ = !winding_.empty() || !steady;
    // Two caps together may still hide something between them: a lens.
    return !hidden_.empty() && !(hidden_.size() == 1 && steady);
}

bool LeafProbe::is_flat(const TreeNode& leaf) const {
    constexpr double kAround = 1.0 / 8;  // cells
    const double edge = octree::Octree::edge_of(tree_.level_of(leaf.morton));
    const Vec3 x = middle_of(leaf);
    const std::uint32_t* words = tree_.tapes.data() + leaf.tape_offset;
    std::uint32_t last = 0xffffffffu;
    for (std::uint32_t i = 0; i < leaf.tape_length; ++i) {
        if (tape_operation(words[i]) != kTapeLiteral || tape_surface(words[i]) == last) continue;
        last = tape_surface(words[i]);
        const Surface& surface = model_.surfaces[last];
        if (surface.kind != kSurfaceExpression) continue;
        const auto is_zero = [&](std::size_t axis, double by) {
            Vec3 at = x;
            at[axis] += by * edge;
            return surface_value(&surface, model_.expression_ops.data(), at[0], at[1], at[2]) == 0;
        };
        bool flat = is_zero(0, 0);
        for (std::size_t axis = 0; axis < 3 && flat; ++axis)
            flat = is_zero(axis, -kAround) && is_zero(axis, kAround);
        if (flat) return true;
    }
    return false;
}

void LeafProbe::take_signs(const Vec3& x) {
    signs_.resize(surfaces_.size());
    values_here_.resize(surfaces_.size());
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        values_here_[s] =
            surface_value(&model_.surfaces[surfaces_[s]], model_.expression_ops.data(), x[0], x[1], x[2]);
        signs_[s] = tape::sign_of(values_here_[s]);
    }
}

/// Whether the solid at x, where signs_ are known, differs from what it is with the hidden surfaces' signs at
/// the samples.
bool LeafProbe::differs_here(const Vec3& x, Found& found) {
    assumed_ = signs_;
    bool contrary = false;
    double deepest = 0;
    for (std::size_t h = 0; h < hidden_.size(); ++h) {
        if (signs_[hidden_[h]] == hidden_sign_[h]) continue;
        contrary = true;
        assumed_[hidden_[h]] = hidden_sign_[h];
        deepest = std::max(deepest, std::fabs(values_here_[hidden_[h]]));
    }
    if (!contrary) return false;
    const std::int32_t region = local_tape_.resolve(signs_.data());
    if (region == local_tape_.resolve(assumed_.data())) return false;
    found = {region, x, deepest};
    return true;
}

bool LeafProbe::is_missed(const Vec3& x, Found& found) {
    take_signs(x);
    return differs_here(x, found);
}

/// The same at many points: found_at_.
void LeafProbe::find_missed_at(const std::vector<Vec3>& points) {
    values_at_.resize(surfaces_.size());
    for (std::size_t s = 0; s < surfaces_.size(); ++s)
        batch_.values(surfaces_[s], tape::Places(points), values_at_[s]);
    found_at_.assign(points.size(), Found{});
    signs_.resize(surfaces_.size());
    values_here_.resize(surfaces_.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            values_here_[s] = values_at_[s][k];
            signs_[s] = tape::sign_of(values_here_[s]);
        }
        differs_here(points[k], found_at_[k]);
    }
}

void LeafProbe::run(std::uint32_t leaf, std::vector<Component>& out) {
    if (load(leaf)) {
        keep_watch();
        ++probed_;
        subdivide();
        if (!found_.empty()) gather(leaf, out);
    }
    if (!winding_.empty()) find_sections(leaf, out);
}

void LeafProbe::gather(std::uint32_t leaf, std::vector<Component>& out) {
    const std::size_t first = out.size();
    layer_.assign(kPieces, 0);  // 1: already in a component
    for (std::uint32_t seed = 0; seed < kPieces; ++seed) {
        if (found_[seed].region < 0 || layer_[seed] != 0) continue;
        Component component;
        component.leaf = leaf;
        component.region = static_cast<std::uint16_t>(found_[seed].region);
        component.pieces.push_back(static_cast<std::uint16_t>(seed));
        layer_[seed] = 1;
        for (std::size_t i = 0; i < component.pieces.size(); ++i) {
            for (int f = 0; f < 6; ++f) {
                const std::uint32_t other = neighbour(component.pieces[i], f);
                if (other == kPieces || layer_[other] != 0) continue;
                if (found_[other].region != component.region) continue;
                layer_[other] = 1;
                component.pieces.push_back(static_cast<std::uint16_t>(other));
            }
        }
        std::sort(component.pieces.begin(), component.pieces.end());
        out.push_back(std::move(component));
    }
    std::size_t largest = first;
    for (std::size_t i = first; i < out.size(); ++i) {
        finish(out[i]);
        measure(out[i]);
        if (out[i].pieces.size() > out[largest].pieces.size()) largest = i;
    }
    // One cone has one apex.
    for (std::size_t i = first; i < out.size(); ++i)
        out[i].usable = i == largest && sees_all(out[i]) && !needs_centre();
}

/// Depth, point and contacts of a component. Pieces at the leaf's faces count as on its rim: the point keeps
/// away from them.
void LeafProbe::finish(Component& component) {
    std::vector<std::uint16_t> front;
    std::vector<std::uint16_t> next;
    std::fill(layer_.begin(), layer_.end(), std::uint8_t{0});
    for (const std::uint16_t piece : component.pieces) {
        bool rim = false;
        bool open = false;
        for (int f = 0; f < 6; ++f) {
            const std::uint32_t other = neighbour(piece, f);
            if (other == kPieces || found_[other].region != component.region) rim = true;
            if (other == kPieces || found_[other].region >= 0 || open) continue;
            Found unused;
            const Vec3 x = centre(other);
            // Not missed, so meshed as what it is.
            take_signs(x);
            open = local_tape_.resolve(signs_.data()) == component.region && !is_missed(x, unused);
        }
        if (open) component.open.push_back(piece);
        if (rim) {
            layer_[piece] = 1;
            front.push_back(piece);
        }
    }
    component.attached = !component.open.empty();
    for (std::uint8_t depth = 1; !front.empty(); ++depth) {
        component.depth = depth;
        next.clear();
        for (const std::uint16_t piece : front) {
            for (int f = 0; f < 6; ++f) {
                const std::uint32_t other = neighbour(piece, f);
                if (other == kPieces || layer_[other] != 0 || found_[other].region != component.region)
                    continue;
                layer_[other] = static_cast<std::uint8_t>(depth + 1);
                next.push_back(static_cast<std::uint16_t>(other));
            }
        }
        front.swap(next);
    }
    double deepest = -1;
    for (const std::uint16_t piece : component.pieces) {
        if (layer_[piece] != component.depth || found_[piece].value <= deepest) continue;
        deepest = found_[piece].value;
        component.point = found_[piece].point;
    }
}

/// Lengths of the component from its point in some directions (of unit length), within the leaf. All searches
/// go on together, since a surface at many points takes little longer than at one.
std::vector<double> LeafProbe::reaches(const Component& component, const std::vector<Vec3>& directions) {
    constexpr double kFirst = 1e-6;  ///< of the leaf's edge, as all lengths here
    constexpr double kLongest = 2;
    constexpr int kHalvings = 12;
    struct Search {
        double low = 0;
        double high = kFirst;
        int halvings = -1;  ///< -1: `high` still grows

        bool is_done() const { return halvings == kHalvings; }
        double next() const { return halvings < 0 ? high : 0.5 * (low + high); }
        void learn(bool inside) {
            if (halvings >= 0) {
                (inside ? low : high) = next();
                ++halvings;
            } else if (inside) {
                low = high;
                high *= 2;
                if (!(high < kLongest)) halvings = 0;
            } else {
                halvings = 0;
            }
        }
    };
    std::vector<Search> searches(directions.size());
    std::vector<std::size_t> asked;
    std::vector<Vec3> points;
    while (true) {
        asked.clear();
        points.clear();
        for (std::size_t k = 0; k < searches.size(); ++k) {
            // Beyond the leaf nothing need be asked.
            while (!searches[k].is_done()) {
                const double t = searches[k].next();
                Vec3 x{};
                bool is_in_leaf = true;
                for (std::size_t j = 0; j < 3; ++j) {
                    x[j] = component.point[j] + t * edge_ * directions[k][j];
                    is_in_leaf = is_in_leaf && x[j] >= low_[j] && x[j] <= low_[j] + edge_;
                }
                if (is_in_leaf) {
                    asked.push_back(k);
                    points.push_back(x);
                    break;
                }
                searches[k].learn(false);
            }
        }
        if (asked.empty()) break;
        find_missed_at(points);
        for (std::size_t i = 0; i < asked.size(); ++i)
            searches[asked[i]].learn(found_at_[i].region == component.region);
    }
    std::vector<double> lengths;
    for (const Search& search : searches) lengths.push_back(search.low * edge_);
    return lengths;
}

/// Moves the component's point to the middle of its chords along the axes, which for a ball is its centre,
/// and takes the shortest chord through it along 13 directions.
void LeafProbe::measure(Component& component) {
    for (std::size_t axis = 0; axis < 6; ++axis) {
        Vec3 forward{};
        Vec3 back{};
        forward[axis % 3] = 1;
        back[axis % 3] = -1;
        const std::vector<double> chord = reaches(component, {forward, back});
        const double before = component.point[axis % 3];
        component.point[axis % 3] += 0.5 * (chord[0] - chord[1]);
        Found at;
        if (!is_missed(component.point, at) || at.region != component.region)
            component.point[axis % 3] = before;
    }
    std::vector<Vec3> directions;
    for (int k = 14; k < 27; ++k) {
        const std::array<int, 3> d = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const double length = std::sqrt(static_cast<double>(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        for (const double side : {-1.0, 1.0}) {
            Vec3 direction{};
            for (std::size_t j = 0; j < 3; ++j) direction[j] = side * d[j] / length;
            directions.push_back(direction);
        }
    }
    const std::vector<double> lengths = reaches(component, directions);
    component.thickness = 2 * edge_;
    for (std::size_t k = 0; k < lengths.size(); k += 2)
        component.thickness = std::min(component.thickness, lengths[k] + lengths[k + 1]);
}

/// Whether only the leaf's centre tells that some surface passes through it: the apex must stay there then.
bool LeafProbe::needs_centre() const {
    for (const std::uint32_t surface : surfaces_) {
        const auto sign = [&](double x, double y, double z) {
            return surface_sign(&model_.surfaces[surface], model_.expression_ops.data(), low_[0] + x * edge_,
                                low_[1] + y * edge_, low_[2] + z * edge_, edge_);
        };
        const int centre = sign(0.5, 0.5, 0.5);
        bool alone = centre != 0;
        for (int c = 0; c < 8 && alone; ++c) alone = sign(c & 1, (c >> 1) & 1, c >> 2) == -centre;
        if (alone) return true;
    }
    return false;
}

/// Whether the whole component is visible from its point, so that a cone from there has its topology, and the
/// point is far enough from the leaf's faces.
bool LeafProbe::sees_all(const Component& component) {
    constexpr double kMargin = 1.0 / 64;
    for (std::size_t j = 0; j < 3; ++j) {
        const double x = (component.point[j] - low_[j]) / edge_;
        if (!(x > kMargin && x < 1 - kMargin)) return false;
    }
    for (const std::uint16_t piece : component.pieces) {
        const Vec3& to = found_[piece].point;
        double length = 0;
        for (std::size_t j = 0; j < 3; ++j) length = std::max(length, std::fabs(to[j] - component.point[j]));
        const int steps = static_cast<int>(2 * kSide * length / edge_) + 1;
        for (int i = 1; i < steps; ++i) {
            Found at;
            Vec3 x{};
            for (std::size_t j = 0; j < 3; ++j)
                x[j] = component.point[j] + (to[j] - component.point[j]) * i / steps;
            if (!is_missed(x, at) || at.region != component.region) return false;
        }
    }
    return true;
}

}  // namespace mortise::probe
