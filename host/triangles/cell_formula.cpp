#include "host/triangles/cell_formula.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "host/common/sort_unique.hpp"
#include "kernels/shared/tape.h"

namespace mortise::triangles {
namespace {

// Corners of a flat face are off its plane by 1e-6 of the surface's size (tape::find_facets), at most.
constexpr double kTolerance = 2e-6;
constexpr double kToleranceInCells = 1e-3;
constexpr std::size_t kMostCandidates = 12;  ///< planes that are tried for one division
// Samples lie this far beside a polygon, in cells: close enough to see nothing else.
constexpr double kStep = 1e-3;
constexpr std::size_t kMostPieces = 6;  ///< of one surface that are sampled
constexpr std::size_t kMostAlike = 3;   ///< samples that must agree
constexpr int kGrid = 3;                ///< samples along an edge of the cell
constexpr double kGridWeight = 1e-3;    ///< area that a grid sample counts for, in cell faces
constexpr std::size_t kMostPlaces = 3;  ///< of one crease that are sampled
constexpr double kLeastTurn = 1e-4;     ///< surfaces more alike, by the determinant of normals, tell nothing

glm::dvec3 gradient(const SurfaceSample& s) { return {s.gradient[0], s.gradient[1], s.gradient[2]}; }

}  // namespace

void CellFormula::make(const std::vector<Polygon>& polygons, const glm::dvec3& centre, double cell_size) {
    cell_size_ = cell_size;
    tolerance_ = std::min(kTolerance, kToleranceInCells * cell_size);
    terms_.assign(2, {});
    words_.clear();
    surfaces_.clear();
    for (const Polygon& polygon : polygons) surfaces_.push_back(polygon.surface);
    sort_unique(surfaces_);
    const bool flat = std::all_of(surfaces_.begin(), surfaces_.end(), [this](std::uint32_t surface) {
        return model_.surfaces[surface].kind == kSurfacePlane;
    });
    root_ = flat ? divide(polygons) : decide(take_samples(polygons, centre));
    if (!is_constant()) emit(root_);
}

std::vector<CellFormula::Sample> CellFormula::take_samples(const std::vector<Polygon>& polygons,
                                                           const glm::dvec3& centre) const {
    std::vector<Sample> samples;
    const auto add = [&](const glm::dvec3& x, double weight, int side = 0) {
        Sample sample;
        for (const std::uint32_t surface : surfaces_) {
            sample.behind.push_back(
                surface_value(&model_.surfaces[surface], model_.expression_ops.data(), x.x, x.y, x.z) < 0);
        }
        sample.at = x;
        sample.weight = weight;
        sample.side = side;
        samples.push_back(std::move(sample));
    };
    for (const std::uint32_t surface : surfaces_) {
        // The largest pieces of a surface stand for all; where it is alone, one does.
        std::vector<std::pair<double, const Polygon*>> pieces;
        for (const Polygon& polygon : polygons) {
            if (polygon.surface == surface) pieces.emplace_back(polygon.area(), &polygon);
        }
        const std::size_t most = surfaces_.size() == 1 ? 1 : kMostPieces;
        if (pieces.size() > most) {
            std::stable_sort(pieces.begin(), pieces.end(),
                             [](const auto& p, const auto& q) { return p.first > q.first; });
            pieces.resize(most);
        }
        for (const auto& [area, polygon] : pieces) {
            const double step = std::min(kStep * cell_size_, 0.2 * area / polygon->perimeter());
            const glm::dvec3 middle = polygon->centre();
            const glm::dvec3 normal = polygon->unit_normal();
            for (const int side : {-1, 1}) add(middle + side * step * normal, area, side);
        }
    }
    if (surfaces_.size() > 1) sample_creases(polygons, add);
    // Where one surface passes, its own two sides tell all.
    const int grid = surfaces_.size() == 1 ? 0 : kGrid;
    for (int i = 0; i < grid * grid * grid; ++i) {
        const glm::dvec3 at(i % grid, i / grid % grid, i / (grid * grid));
        add(centre + (at - 0.5 * (grid - 1)) / static_cast<double>(grid) * cell_size_,
            kGridWeight * cell_size_ * cell_size_);
    }
    find_solid(samples);
    return samples;
}

/// Around places where two surfaces meet, or three: a point for each choice of their signs. Some choices
/// occur nowhere else, as in the corner of a cell between a hole and the cone beside which it ends.
template <class Add>
void CellFormula::sample_creases(const std::vector<Polygon>& polygons, const Add& add) const {
    std::map<std::vector<std::uint32_t>, std::vector<glm::dvec3>> places;
    std::set<std::tuple<std::uint32_t, double, double, double>> seen;  // neighbours share their corners
    const double near = std::max(tolerance_, 1e-5 * cell_size_);
    for (const Polygon& polygon : polygons) {
        for (int k = 0; k < polygon.count; ++k) {
            const glm::dvec3& x = polygon.corner[static_cast<std::size_t>(k)];
            if (!seen.insert({polygon.surface, x.x, x.y, x.z}).second) continue;
            std::vector<std::uint32_t> here;
            for (const std::uint32_t surface : surfaces_) {
                if (surface == polygon.surface || is_on(surface, x, near)) here.push_back(surface);
            }
            if (here.size() < 2 || here.size() > 3) continue;
            std::vector<glm::dvec3>& list = places[here];
            const bool known = std::any_of(list.begin(), list.end(), [&](const glm::dvec3& y) {
                return glm::length(x - y) <= kStep * cell_size_;
            });
            if (!known && list.size() < kMostPlaces) list.push_back(x);
        }
    }
    const double step = kStep * cell_size_;
    for (const auto& [here, list] : places) {
        for (const glm::dvec3& x : list) {
            // A third direction, along which all is alike, if there are two surfaces.
            glm::dmat3 normals(0.0);
            for (std::size_t i = 0; i < here.size(); ++i)
                normals[static_cast<int>(i)] = glm::normalize(gradient(sample(here[i], x)));
            if (here.size() == 2) normals[2] = glm::cross(normals[0], normals[1]);
            if (!(std::fabs(glm::determinant(normals)) > kLeastTurn)) continue;
            const glm::dmat3 inverse = glm::inverse(glm::transpose(normals));
            for (std::uint32_t choice = 0; choice < 1U << here.size(); ++choice) {
                glm::dvec3 side(0.0);
                for (std::size_t i = 0; i < here.size(); ++i)
                    side[static_cast<int>(i)] = (choice >> i & 1) != 0 ? 1 : -1;
                add(x + step * glm::normalize(inverse * side), kGridWeight * cell_size_ * cell_size_);
            }
        }
    }
}

/// Winding numbers cost most: of samples on the same sides of all surfaces, which no formula tells apart, the
/// heaviest few stand for all if they agree. Beside polygons of a closed surface they do as soon as one of
/// them is found to lie on its polygon's side of the solid.
void CellFormula::find_solid(std::vector<Sample>& samples) const {
    std::stable_sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
        return a.behind != b.behind ? a.behind < b.behind : a.weight > b.weight;
    });
    for (std::size_t i = 0, first = 0; i < samples.size(); ++i) {
        if (samples[i].behind != samples[first].behind) first = i;
        const Sample& found = samples[first];
        const bool is_sound =
            winding_.is_closed() && i > first && found.side != 0 && found.solid == (found.side < 0);
        bool agree = i >= first + kMostAlike || (is_sound && samples[i].side == found.side);
        for (std::size_t k = first; agree && k < i; ++k) agree = samples[k].solid == found.solid;
        samples[i].solid = agree ? found.solid : winding_.is_inside(samples[i].at);
    }
}

/// The surface that tells solid samples best from others comes first; what has no samples does not matter.
std::uint32_t CellFormula::decide(const std::vector<Sample>& samples) {
    double solid = 0;
    double empty = 0;
    for (const Sample& sample : samples) (sample.solid ? solid : empty) += sample.weight;
    if (solid == 0 || empty == 0) return solid > 0 ? kTrue : kFalse;
    std::size_t best = surfaces_.size();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        double weight[2][2] = {{0, 0}, {0, 0}};
        for (const Sample& sample : samples) weight[sample.behind[s]][sample.solid] += sample.weight;
        double impurity = 0;
        bool divides = true;
        for (const auto& side : weight) {
            const double total = side[0] + side[1];
            divides = divides && total > 0;
            if (total > 0) impurity += side[0] * side[1] / total;
        }
        if (divides && impurity < least) {
            least = impurity;
            best = s;
        }
    }
    // Signs that tell nothing more: overlaps, holes, or features below the sampling.
    if (best == surfaces_.size()) return solid > empty ? kTrue : kFalse;
    std::vector<Sample> behind;
    std::vector<Sample> before;
    for (const Sample& sample : samples) (sample.behind[best] ? behind : before).push_back(sample);
    const std::uint32_t inner = decide(behind);
    const std::uint32_t outer = decide(before);
    return combine(surfaces_[best], inner, outer);
}

SurfaceSample CellFormula::sample(std::uint32_t surface, const glm::dvec3& x) const {
    return surface_sample(&model_.surfaces[surface], model_.expression_ops.data(), x.x, x.y, x.z);
}

bool CellFormula::is_on(std::uint32_t surface, const glm::dvec3& x, double near) const {
    const SurfaceSample s = sample(surface, x);
    return std::fabs(s.value) <= near * glm::length(gradient(s));
}

CutPlane CellFormula::plane(std::uint32_t surface) const {
    const double* map = model_.surfaces[surface].map;
    return {{map[0], map[1], map[2]}, map[3]};
}

/// The plane that cuts the fewest other polygons, best of all with all of them on one side.
std::uint32_t CellFormula::choose_plane(const std::vector<Polygon>& polygons) const {
    std::vector<std::uint32_t> candidates;
    for (const Polygon& polygon : polygons) {
        if (std::find(candidates.begin(), candidates.end(), polygon.surface) == candidates.end()) {
            candidates.push_back(polygon.surface);
        }
        if (candidates.size() == kMostCandidates) break;
    }
    std::sort(candidates.begin(), candidates.end());
    std::uint32_t best = candidates[0];
    int best_cost = std::numeric_limits<int>::max();
    for (const std::uint32_t candidate : candidates) {
        const CutPlane cut = plane(candidate);
        int cuts = 0;
        int front = 0;
        int back = 0;
        for (const Polygon& polygon : polygons) {
            if (polygon.surface == candidate) continue;
            const auto [low, high] = range_of(polygon, cut);
            if (low < -tolerance_ && high > tolerance_) {
                ++cuts;
            } else {
                ++(high > -low ? front : back);
            }
        }
        const bool one_sided = cuts == 0 && (front == 0 || back == 0);
        const int cost = one_sided ? -1 : 8 * cuts + std::abs(front - back);
        if (cost < best_cost) {
            best_cost = cost;
            best = candidate;
        }
    }
    return best;
}

bool CellFormula::is_solid_beside(const std::vector<Polygon>& polygons, std::uint32_t surface,
                                  int side) const {
    const Polygon* largest = nullptr;
    double area = -1;
    for (const Polygon& polygon : polygons) {
        if (polygon.surface != surface || polygon.area() <= area) continue;
        area = polygon.area();
        largest = &polygon;
    }
    const double step = std::min(kStep * cell_size_, 0.2 * area / largest->perimeter());
    return winding_.is_inside(largest->centre() + side * step * plane(surface).normal);
}

std::uint32_t CellFormula::divide(std::vector<Polygon> polygons) {
    const std::uint32_t surface = choose_plane(polygons);
    const CutPlane cut = plane(surface);
    std::vector<Polygon> behind;
    std::vector<Polygon> before;
    for (const Polygon& polygon : polygons) {
        if (polygon.surface == surface) continue;
        const auto [low, high] = range_of(polygon, cut);
        if (low < -tolerance_ && high > tolerance_) {
            const Polygon a = part_of(polygon, cut, -1, tolerance_);
            const Polygon b = part_of(polygon, cut, 1, tolerance_);
            if (a.count >= 3) behind.push_back(a);
            if (b.count >= 3) before.push_back(b);
        } else {
            (high > -low ? before : behind).push_back(polygon);
        }
    }
    const bool solid_behind = behind.empty() && is_solid_beside(polygons, surface, -1);
    const bool solid_before = before.empty() && is_solid_beside(polygons, surface, 1);
    polygons = {};  // not held through the recursion
    const std::uint32_t inner = behind.empty() ? (solid_behind ? kTrue : kFalse) : divide(std::move(behind));
    const std::uint32_t outer = before.empty() ? (solid_before ? kTrue : kFalse) : divide(std::move(before));
    return combine(surface, inner, outer);
}

/// (f < 0 and inner) or (f > 0 and outer).
std::uint32_t CellFormula::combine(std::uint32_t surface, std::uint32_t inner, std::uint32_t outer) {
    if (inner == outer) return inner;
    if (inner == kTrue) return add_operation(kTapeOr, add_literal(surface, false), outer);
    if (outer == kTrue) return add_operation(kTapeOr, add_literal(surface, true), inner);
    const std::uint32_t a = add_operation(kTapeAnd, add_literal(surface, false), inner);
    const std::uint32_t b = add_operation(kTapeAnd, add_literal(surface, true), outer);
    return add_operation(kTapeOr, a, b);
}

std::uint32_t CellFormula::add_literal(std::uint32_t surface, bool negated) {
    return add_term({make_literal(surface, negated ? 1 : 0), 0, 0, 1});
}

/// Equal terms have equal numbers, so that a division that changes nothing is seen.
std::uint32_t CellFormula::add_term(const Term& term) {
    for (std::uint32_t i = 2; i < terms_.size(); ++i) {
        const Term& t = terms_[i];
        if (t.word == term.word && t.first == term.first && t.second == term.second) return i;
    }
    terms_.push_back(term);
    return static_cast<std::uint32_t>(terms_.size() - 1);
}

std::uint32_t CellFormula::add_operation(std::uint32_t operation, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t absorbing = operation == kTapeAnd ? kFalse : kTrue;
    const std::uint32_t neutral = operation == kTapeAnd ? kTrue : kFalse;
    if (a == absorbing || b == absorbing) return absorbing;
    if (a == neutral) return b;
    if (b == neutral) return a;
    if (terms_[a].need < terms_[b].need) std::swap(a, b);
    return add_term({make_operation(operation, 0, 0), a, b, std::max(terms_[a].need, 1 + terms_[b].need)});
}

void CellFormula::emit(std::uint32_t term) {
    const Term& t = terms_[term];
    if (tape_operation(t.word) != kTapeLiteral) {
        emit(t.first);
        emit(t.second);
    }
    words_.push_back(t.word);
}

}  // namespace mortise::triangles
