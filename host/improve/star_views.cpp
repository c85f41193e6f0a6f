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

using Lanes = double __attribute__((vector_size(8 * sizeof(double))));

[[gnu::always_inline]] inline Lanes load(const std::array<double, 8>& row) {
    Lanes lanes;
    std::memcpy(&lanes, row.data(), sizeof lanes);
    return lanes;
}
[[gnu::always_inline]] inline Vector<Lanes> load(const std::array<std::array<double, 8>, 3>& rows) {
    return {load(rows[0]), load(rows[1]), load(rows[2])};
}
[[gnu::always_inline]] inline void store(const Lanes& lanes, std::array<double, 8>& row) {
    std::memcpy(row.data(), &lanes, sizeof lanes);
}

}  // namespace

MORTISE_WIDE void StarViews::evaluate(Group& group, const Point& p, double rounding) {
    OppositeFace<Lanes> face;
    face.b = load(group.b);
    face.c = load(group.c);
    face.d = load(group.d);
    face.normal = load(group.normal);
    face.squared_normal = load(group.squared_normal);
    face.l_bc = load(group.l_bc);
    face.l_bd = load(group.l_bd);
    face.l_cd = load(group.l_cd);
    const Lanes zero = {};
    store(squared_quality(face, {zero + p[0], zero + p[1], zero + p[2]}, rounding), group.square);
}

MORTISE_WIDE void StarViews::prepare(Group& group) {
    OppositeFace<Lanes> face;
    face.b = load(group.b);
    face.c = load(group.c);
    face.d = load(group.d);
    set_face(face);
    store(face.normal.x, group.normal[0]);
    store(face.normal.y, group.normal[1]);
    store(face.normal.z, group.normal[2]);
    store(face.squared_normal, group.squared_normal);
    store(face.l_bc, group.l_bc);
    store(face.l_bd, group.l_bd);
    store(face.l_cd, group.l_cd);
}

void StarViews::clear() {
    size_ = 0;
    order_.clear();
}

void StarViews::add(const std::array<std::uint32_t, 3>& nodes, const Point& b, const Point& c,
                    const Point& d) {
    const std::size_t lane = size_ % kLanes;
    if (lane == 0) {
        order_.push_back(static_cast<std::uint32_t>(order_.size()));
        if (groups_.size() < order_.size()) groups_.emplace_back();
    }
    Group& group = groups_[order_.size() - 1];
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
    Group& last = groups_[order_.size() - 1];
    for (std::size_t lane = (size_ - 1) % kLanes + 1; lane < kLanes; ++lane) {
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
        Group& group = groups_[order_[i]];
        evaluate(group, p, rounding);
        cost_ += kGroupCost;
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
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
    const double square = groups_[i / kLanes].square[i % kLanes];
    return square < 0 ? kInvertedQuality : std::sqrt(square);
}

}  // namespace mortise::improve
