#include "host/improve/star_views.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/common/wide.hpp"
#include "host/improve/quality_formula.hpp"

namespace mortise::improve {
namespace {

/// What a group costs, in single evaluations.
constexpr std::uint64_t kGroupCost = 2;

using Row = std::array<double, StarGroup::kLanes>;

template <class Lanes>
[[gnu::always_inline]] inline Lanes load(const Row& row, std::size_t first) {
    Lanes lanes;
    std::memcpy(&lanes, row.data() + first, sizeof lanes);
    return lanes;
}
template <class Lanes>
[[gnu::always_inline]] inline Vector<Lanes> load(const std::array<Row, 3>& rows, std::size_t first) {
    return {load<Lanes>(rows[0], first), load<Lanes>(rows[1], first), load<Lanes>(rows[2], first)};
}
template <class Lanes>
[[gnu::always_inline]] inline void store(const Lanes& lanes, Row& row, std::size_t first) {
    std::memcpy(row.data() + first, &lanes, sizeof lanes);
}

template <class Lanes>
[[gnu::always_inline]] inline OppositeFace<Lanes> load_corners(const StarGroup& group, std::size_t first) {
    OppositeFace<Lanes> face;
    face.b = load<Lanes>(group.b, first);
    face.c = load<Lanes>(group.c, first);
    face.d = load<Lanes>(group.d, first);
    return face;
}

template <std::size_t kWidth>
[[gnu::always_inline]] inline void evaluate_in(StarGroup& group, const Point& p, double rounding) {
    using Lanes = lanes::Doubles<kWidth>;
    for (std::size_t i = 0; i < StarGroup::kLanes; i += kWidth) {
        OppositeFace<Lanes> face = load_corners<Lanes>(group, i);
        face.normal = load<Lanes>(group.normal, i);
        face.squared_normal = load<Lanes>(group.squared_normal, i);
        face.l_bc = load<Lanes>(group.l_bc, i);
        face.l_bd = load<Lanes>(group.l_bd, i);
        face.l_cd = load<Lanes>(group.l_cd, i);
        const Lanes zero = {};
        const Vector<Lanes> place = {zero + p[0], zero + p[1], zero + p[2]};
        store(squared_quality(face, place, rounding), group.square, i);
    }
}

/// What does not depend on the node's place.
template <std::size_t kWidth>
[[gnu::always_inline]] inline void prepare_in(StarGroup& group) {
    using Lanes = lanes::Doubles<kWidth>;
    for (std::size_t i = 0; i < StarGroup::kLanes; i += kWidth) {
        OppositeFace<Lanes> face = load_corners<Lanes>(group, i);
        set_face(face);
        store(face.normal.x, group.normal[0], i);
        store(face.normal.y, group.normal[1], i);
        store(face.normal.z, group.normal[2], i);
        store(face.squared_normal, group.squared_normal, i);
        store(face.l_bc, group.l_bc, i);
        store(face.l_bd, group.l_bd, i);
        store(face.l_cd, group.l_cd, i);
    }
}

MORTISE_BY_WIDTH(void, evaluate, (StarGroup & group, const Point& p, double rounding), (group, p, rounding))
MORTISE_BY_WIDTH(void, prepare, (StarGroup & group), (group))

}  // namespace

void StarViews::clear() {
    size_ = 0;
    order_.clear();
}

void StarViews::add(const std::array<std::uint32_t, 3>& nodes, const Point& b, const Point& c,
                    const Point& d) {
    const std::size_t lane = size_ % StarGroup::kLanes;
    if (lane == 0) {
        order_.push_back(static_cast<std::uint32_t>(order_.size()));
        if (groups_.size() < order_.size()) groups_.emplace_back();
    }
    StarGroup& group = groups_[order_.size() - 1];
    for (std::size_t j = 0; j < 3; ++j) {
        group.b[j][lane] = b[j];
        group.c[j][lane] = c[j];
        group.d[j][lane] = d[j];
    }
    group.nodes[lane] = nodes;
    ++size_;
}

void StarViews::finish() {
    if (size_ == 0) return;
    // Lanes without an element repeat the first.
    StarGroup& last = groups_[order_.size() - 1];
    for (std::size_t lane = (size_ - 1) % StarGroup::kLanes + 1; lane < StarGroup::kLanes; ++lane) {
        for (std::array<Row, 3>* rows : {&last.b, &last.c, &last.d}) {
            for (Row& row : *rows) row[lane] = row[0];
        }
        last.nodes[lane] = last.nodes[0];
    }
    for (const std::uint32_t g : order_) prepare(groups_[g]);
}

double StarViews::worst_at(const Point& p, double enough, double rounding, std::uint32_t except) {
    const double limit = enough < 0 ? kInvertedQuality : enough * enough;
    double worst = kNoElement * kNoElement;
    for (std::size_t i = 0; i < order_.size(); ++i) {
        StarGroup& group = groups_[order_[i]];
        evaluate(group, p, rounding);
        cost_ += kGroupCost;
        for (std::size_t lane = 0; lane < StarGroup::kLanes; ++lane) {
            if (except != kNobody) {
                const auto& n = group.nodes[lane];
                if (n[0] == except || n[1] == except || n[2] == except) continue;
            }
            worst = std::min(worst, group.square[lane]);
        }
        if (worst > limit) continue;
        std::rotate(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(i),
                    order_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        break;
    }
    return worst < 0 ? kInvertedQuality : std::sqrt(worst);
}

double StarViews::quality(std::size_t i) const {
    const double square = groups_[i / StarGroup::kLanes].square[i % StarGroup::kLanes];
    return square < 0 ? kInvertedQuality : std::sqrt(square);
}

}  // namespace mortise::improve
