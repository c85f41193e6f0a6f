#include "host/sizing/topology.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/common/sort_unique.hpp"

namespace mortise::sizing {
namespace {

constexpr double kSameSheet = 0.9063;   ///< cosine of 25°
constexpr double kMeet = 1.0 / 256;     ///< of a node: sheets this close touch, if no finest leaf is told
constexpr double kNearCrease = 1;       ///< edges from the node
constexpr double kNearSharpCrease = 2;  ///< likewise; a wedge of 27° is thinner than a node up to there

/// x with A x = b for a symmetric positive definite A.
Vec3 solve(const std::array<Vec3, 3>& a, const Vec3& b) {
    const Vec3 minor = {a[1][1] * a[2][2] - a[1][2] * a[2][1], a[0][2] * a[2][1] - a[0][1] * a[2][2],
                        a[0][1] * a[1][2] - a[0][2] * a[1][1]};
    const Vec3 second = {minor[1], a[0][0] * a[2][2] - a[0][2] * a[2][0],
                         a[0][2] * a[1][0] - a[0][0] * a[1][2]};
    const Vec3 third = {minor[2], second[2], a[0][0] * a[1][1] - a[0][1] * a[1][0]};
    const double determinant = dot(a[0], minor);
    return {dot(minor, b) / determinant, dot(second, b) / determinant, dot(third, b) / determinant};
}

}  // namespace

Topology::Topology(const tape::BoundModel& model, double finest)
    : model_(model), finest_(finest), finder_(model), of_polyhedron_(model.surfaces.size(), false) {
    for (const std::uint32_t word : model.tape) {
        root_is_spatial_ = root_is_spatial_ || tape_operation(word) == kTapeSpatial;
        if (tape_operation(word) == kTapeLiteral) root_surfaces_.push_back(tape_surface(word));
    }
    sort_unique(root_surfaces_);
    for (const tape::BoundPolyhedron& polyhedron : model.polyhedra) {
        for (const std::uint32_t surface : polyhedron.surface) of_polyhedron_[surface] = true;
    }
}

void Topology::load(const std::uint32_t* words, std::size_t length, const tape::Cell& cell) {
    cell_ = cell;
    // Where nothing bounds the solid inside, it does so near the node's boundary.
    for (const bool closely : {false, true}) {
        finder_.run(words, length, cell, closely);
        sheets_ = finder_.sheets();
        keep_bounding(words, length);
        if (!sheets_.empty()) return;
    }
}

/// Leaves the sheets at which the region changes, and finds their sides.
void Topology::keep_bounding(const std::uint32_t* words, std::size_t length) {
    if (sheets_.empty()) return;
    if (!possible_.find(sheets_, finder_.seen(cell_))) {
        orient_by_tape(words, length);
        return;
    }
    arrangement_.load(words, length, finder_.surfaces(), finder_.signs(), possible_.choices());
    one_region_ = arrangement_.is_one_region();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sheets_.size(); ++i) {
        if (!arrangement_.bounds(i)) continue;
        sheets_[i].orientation = arrangement_.orientation(i);
        if (kept != i) sheets_[kept] = sheets_[i];
        ++kept;
    }
    sheets_.resize(kept);
}

/// Too many for all choices of signs: sides as the tape has them. In formulas of polyhedra a plane may occur
/// both ways, but it faces outwards.
void Topology::orient_by_tape(const std::uint32_t* words, std::size_t length) {
    int selects = 0;
    std::vector<int> seen(sheets_.size(), 0);  // 1: plain, 2: negated
    for (std::size_t i = 0; i < length; ++i) {
        const std::uint32_t operation = tape_operation(words[i]);
        if (operation == kTapeSelect || operation == kTapeSelectConst) ++selects;
        if (operation != kTapeLiteral) continue;
        const auto at =
            std::lower_bound(sheets_.begin(), sheets_.end(), tape_surface(words[i]),
                             [](const Sheet& s, std::uint32_t surface) { return s.surface < surface; });
        if (at == sheets_.end() || at->surface != tape_surface(words[i])) continue;
        seen[static_cast<std::size_t>(at - sheets_.begin())] |= tape_negated(words[i]) != 0 ? 2 : 1;
    }
    one_region_ = selects == 1;
    for (std::size_t i = 0; i < sheets_.size(); ++i) {
        const bool outward = seen[i] == 1 || (seen[i] == 3 && of_polyhedron_[sheets_[i].surface]);
        sheets_[i].orientation = outward ? 1 : seen[i] == 2 ? -1 : 0;
    }
}

/// Sheets that come as close to a point touch there.
double Topology::touching() const { return finest_ > 0 ? 0.25 * finest_ : 2 * kMeet * cell_.half; }

Vec3 Topology::outward(const Sheet& sheet) const {
    const double sign = sheet.orientation < 0 ? -1 : 1;
    return {sign * sheet.normal[0], sign * sheet.normal[1], sign * sheet.normal[2]};
}

/// All bound one region on the same side of one plane: a graph over it.
bool Topology::is_one_sheet() const {
    if (!one_region_) return false;
    Vec3 sum{};
    for (const Sheet& sheet : sheets_) {
        if (sheet.orientation == 0) return false;
        const Vec3 normal = outward(sheet);
        for (std::size_t j = 0; j < 3; ++j) sum[j] += normal[j];
    }
    const double length = std::sqrt(dot(sum, sum));
    if (!(length > 0.5)) return false;
    return std::all_of(sheets_.begin(), sheets_.end(),
                       [&](const Sheet& sheet) { return dot(outward(sheet), sum) >= kSameSheet * length; });
}

/// Newton's method from the node's centre to the nearest point where all the sheets are zero, up to so many
/// edges from the node.
Topology::Meeting Topology::meet(const std::vector<const Sheet*>& sheets, double edges, Vec3& at) const {
    constexpr int kSteps = 12;
    constexpr double kDamping = 1e-6;  // keeps parallel sheets solvable
    at = {cell_.centre[0], cell_.centre[1], cell_.centre[2]};
    const double edge = 2 * cell_.half;
    for (int step = 0; step < kSteps; ++step) {
        std::array<Vec3, 3> square = {Vec3{kDamping, 0, 0}, Vec3{0, kDamping, 0}, Vec3{0, 0, kDamping}};
        Vec3 right{};
        double farthest = 0;
        for (const Sheet* sheet : sheets) {
            const Sampled s = sample_at(model_, sheet->surface, at);
            const Vec3& g = s.gradient;
            const double slope = s.slope;
            const double distance = s.value / slope;
            if (!(slope > 0) || !std::isfinite(distance)) return Meeting::kNone;
            farthest = std::max(farthest, std::fabs(distance));
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) square[i][j] += g[i] * g[j] / (slope * slope);
                right[i] -= distance * g[i] / slope;
            }
        }
        const bool touch = farthest <= touching();
        if (touch && is_within(at, cell_, 1)) return Meeting::kInside;
        if (touch && is_within(at, cell_, 1 + 2 * edges)) return Meeting::kBeyond;
        Vec3 move = solve(square, right);
        const double length = std::sqrt(dot(move, move));
        if (!(length > 1e-4 * edge)) break;  // a point between them
        const double shorten = std::min(1.0, 1.5 * edge / length);
        for (std::size_t j = 0; j < 3; ++j) at[j] += shorten * move[j];
        if (!is_within(at, cell_, 3 + 4 * edges)) break;
    }
    return Meeting::kNone;
}

bool Topology::meet_near(std::uint32_t a, std::uint32_t b, const tape::Cell& cell) {
    Sheet first;
    Sheet second;
    first.surface = a;
    second.surface = b;
    cell_ = cell;
    Vec3 at{};
    return meet({&first, &second}, kNearSharpCrease, at) != Meeting::kNone;
}

/// Whether the solid ends at all of these sheets around a point on them outside the node: by the whole tape.
/// Other surfaces through the point may have any sign.
bool Topology::bound_solid(const std::vector<const Sheet*>& sheets, const Vec3& at) {
    constexpr std::size_t kMostFree = 10;
    if (root_is_spatial_) return true;
    root_signs_.clear();
    asked_.clear();
    std::size_t next = 0;
    std::size_t free = 0;
    for (const std::uint32_t surface : root_surfaces_) {
        const Sampled s = sample_at(model_, surface, at);
        const bool is_asked = next < sheets.size() && sheets[next]->surface == surface;
        const bool is_free = is_asked || std::fabs(s.value) <= 2 * touching() * s.slope;
        if (is_asked) asked_.push_back(free);
        next += is_asked ? 1U : 0U;
        free += is_free ? 1U : 0U;
        root_signs_.push_back(is_free ? std::int8_t{0} : s.value <= 0 ? std::int8_t{-1} : std::int8_t{1});
    }
    if (free > kMostFree) return true;
    all_choices_.resize(std::size_t{1} << free);
    std::iota(all_choices_.begin(), all_choices_.end(), 0U);
    at_point_.load(model_.tape.data(), model_.tape.size(), root_surfaces_, root_signs_, all_choices_);
    return std::all_of(asked_.begin(), asked_.end(), [this](std::size_t i) { return at_point_.bounds(i); });
}

/// Parts of one smooth sheet: on one side, with nearly the same normal, and not one above the other.
bool Topology::is_same_sheet(const Sheet& a, const Sheet& b) {
    if (!one_region_ || a.orientation == 0 || b.orientation == 0) return false;
    if (!a.steady || !b.steady || dot(outward(a), outward(b)) < kSameSheet) return false;
    Vec3 at{};
    return meet({&a, &b}, kNearCrease, at) != Meeting::kNone;
}

/// Groups of sheets that are pairwise the same.
void Topology::merge_sheets() {
    groups_.clear();
    for (const Sheet& sheet : sheets_) {
        const auto fits = std::find_if(groups_.begin(), groups_.end(), [&](const auto& group) {
            return std::all_of(group.begin(), group.end(),
                               [&](const Sheet* other) { return is_same_sheet(*other, sheet); });
        });
        if (fits == groups_.end())
            groups_.push_back({&sheet});
        else
            fits->push_back(&sheet);
    }
}

/// Whether one sheet of each group meet near the node and bound the solid there.
bool Topology::groups_meet() {
    constexpr std::size_t kMostChoices = 16;
    const double edges = groups_.size() == 2 ? kNearSharpCrease : kNearCrease;
    std::size_t choices = 1;
    for (const auto& group : groups_) choices = std::min(kMostChoices, choices * group.size());
    for (std::size_t choice = 0; choice < choices; ++choice) {
        chosen_.clear();
        std::size_t rest = choice;
        for (const auto& group : groups_) {
            chosen_.push_back(group[rest % group.size()]);
            rest /= group.size();
        }
        std::sort(chosen_.begin(), chosen_.end(),
                  [](const Sheet* a, const Sheet* b) { return a->surface < b->surface; });
        Vec3 at{};
        const Meeting meeting = meet(chosen_, edges, at);
        if (meeting == Meeting::kInside || (meeting == Meeting::kBeyond && bound_solid(chosen_, at)))
            return true;
    }
    return false;
}

/// All sheets pass through the cone's apex, which is near: splitting never ends there.
bool Topology::is_apex(const Sheet& cone) const {
    return cone.has_apex && std::all_of(sheets_.begin(), sheets_.end(), [&](const Sheet& sheet) {
               if (&sheet == &cone) return true;
               const Sampled s = sample_at(model_, sheet.surface, cone.apex);
               return std::fabs(s.value) <= touching() * s.slope;
           });
}

bool Topology::is_simple() {
    for (const Sheet& sheet : sheets_) {
        if (!sheet.steady) return is_apex(sheet);
    }
    if (sheets_.size() <= 1 || is_one_sheet()) return true;
    merge_sheets();
    if (groups_.size() <= 1) return true;
    return groups_meet();
}

/// Largest rate at which the normal turns at the sheet's foot. Patches: they turn at edges only.
double Topology::bend(const Sheet& sheet) const {
    constexpr double kStep = 1.0 / 16;  // edges
    if (model_.surfaces[sheet.surface].kind == kSurfacePatch) return 0;
    const std::size_t axis = std::fabs(sheet.normal[0]) < 0.6 ? 0 : 1;
    Vec3 first{};
    first[axis] = 1;
    for (std::size_t j = 0; j < 3; ++j) first[j] -= sheet.normal[axis] * sheet.normal[j];
    const double length = std::sqrt(dot(first, first));
    for (double& c : first) c /= length;
    const Vec3 second = {sheet.normal[1] * first[2] - sheet.normal[2] * first[1],
                         sheet.normal[2] * first[0] - sheet.normal[0] * first[2],
                         sheet.normal[0] * first[1] - sheet.normal[1] * first[0]};
    // The shape operator in the tangent plane: [a b; b c].
    const auto derivative = [&](const Vec3& direction) {
        Vec3 result{};
        for (const double side : {-1.0, 1.0}) {
            Vec3 x = sheet.foot;
            for (std::size_t j = 0; j < 3; ++j) x[j] += side * kStep * 2 * cell_.half * direction[j];
            const Sampled s = sample_at(model_, sheet.surface, x);
            for (std::size_t j = 0; j < 3; ++j)
                result[j] += side * s.gradient[j] / s.slope / (4 * kStep * cell_.half);
        }
        return result;
    };
    const Vec3 along_first = derivative(first);
    const Vec3 along_second = derivative(second);
    const double a = dot(along_first, first);
    const double b = 0.5 * (dot(along_first, second) + dot(along_second, first));
    const double c = dot(along_second, second);
    const double rate = 0.5 * (std::fabs(a + c) + std::hypot(a - c, 2 * b));
    return std::isfinite(rate) ? rate : 0;
}

double Topology::turn() const {
    constexpr double kWithin = 1.2;
    constexpr double kNearby = 2.5;  // a surface that cuts off a corner of the node has its foot outside
    constexpr double kApart = 0.3;   // edges
    double largest = 0;
    const double edge = 2 * cell_.half;
    for (const Sheet& sheet : sheets_) {
        if (sheet.flat) continue;
        std::array<Vec3, Sheet::kSamples> foot;
        std::array<Vec3, Sheet::kSamples> normal;
        std::size_t found = 0;
        if (is_within(sheet.foot, cell_, kNearby)) largest = std::max(largest, bend(sheet) * edge);
        for (std::size_t i = 0; i < Sheet::kSamples; ++i) {
            foot[found] = sample_point(cell_, i);
            double slope = 0;
            if (!project(model_, sheet.surface, cell_.half, foot[found], normal[found], slope)) continue;
            if (is_within(foot[found], cell_, kWithin)) ++found;
        }
        for (std::size_t i = 0; i < found; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                const double apart =
                    std::hypot(foot[i][0] - foot[k][0], foot[i][1] - foot[k][1], foot[i][2] - foot[k][2]);
                if (apart < kApart * edge) continue;
                const double angle = std::acos(std::clamp(dot(normal[i], normal[k]), -1.0, 1.0));
                largest = std::max(largest, angle * edge / apart);
            }
        }
    }
    return largest;
}

}  // namespace mortise::sizing
