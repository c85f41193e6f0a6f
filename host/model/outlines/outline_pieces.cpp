// Loops that are filled by winding, as pieces: see outline_pieces.hpp.
#include "host/model/outlines/outline_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/common/constants.hpp"

namespace mortise::model_reader {
namespace {

double area_of(const std::vector<Vec2>& loop) {
    double sum = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec2& p = loop[i];
        const Vec2& q = loop[(i + 1) % loop.size()];
        sum += (p[0] - loop[0][0]) * (q[1] - loop[0][1]) - (q[0] - loop[0][0]) * (p[1] - loop[0][1]);
    }
    return sum / 2;
}

bool encloses(const std::vector<Vec2>& loop, const Vec2& point) {
    bool inside = false;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec2& p = loop[i];
        const Vec2& q = loop[(i + 1) % loop.size()];
        if ((p[1] > point[1]) == (q[1] > point[1])) continue;
        const double x = p[0] + (point[1] - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
        inside = inside != (point[0] < x);
    }
    return inside;
}

}  // namespace

void add_winding_pieces(Contours loops, std::vector<Contours>& pieces) {
    std::vector<double> areas;
    double largest = 0;
    std::size_t kept = 0;
    for (std::vector<Vec2>& loop : loops) {
        loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
        while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
        const double area = area_of(loop);
        if (loop.size() < 3 || area == 0) continue;
        areas.push_back(area);
        if (std::fabs(area) > std::fabs(largest)) largest = area;
        if (&loops[kept] != &loop) loops[kept] = std::move(loop);
        ++kept;
    }
    loops.resize(kept);
    std::vector<std::size_t> piece_of(kept, 0);
    for (std::size_t i = 0; i < kept; ++i) {
        if ((areas[i] > 0) != (largest > 0)) continue;
        piece_of[i] = pieces.size();
        pieces.push_back({loops[i]});
    }
    for (std::size_t hole = 0; hole < kept; ++hole) {
        if ((areas[hole] > 0) == (largest > 0)) continue;
        // Of the filled loops around it the smallest one.
        std::size_t around = kept;
        for (std::size_t i = 0; i < kept; ++i) {
            if ((areas[i] > 0) != (largest > 0) || !encloses(loops[i], loops[hole][0])) continue;
            if (around == kept || std::fabs(areas[i]) < std::fabs(areas[around])) around = i;
        }
        if (around != kept) pieces[piece_of[around]].push_back(loops[hole]);
    }
}

int fragments_of(double radius, double fn, double fa, double fs) {
    constexpr double kMost = 10000;
    const double wanted = fn > 0 ? std::max(fn, 3.0) : std::max(std::min(360 / fa, radius * kTurn / fs), 5.0);
    return static_cast<int>(std::ceil(std::min(wanted, kMost)));
}

}  // namespace mortise::model_reader
