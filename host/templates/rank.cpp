// How candidates for a template are compared; see rank.hpp.
#include "host/templates/rank.hpp"

#include <algorithm>
#include <cmath>

namespace mortise::templates {
namespace {

/// Steps of 2^(1/7), about 10 %.
int angle_step(double angle) {
    const double cube = angle * angle * angle;
    return angle > 0 ? std::ilogb(cube * cube * angle) : -1000;
}

}  // namespace

double quantile(std::vector<float> values, double fraction) {
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size()));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

void lower(Series& series, const Series& other) {
    for (std::size_t i = 0; i < series.jacobian.size(); ++i) {
        series.jacobian[i] = std::min(series.jacobian[i], other.jacobian[i]);
        series.angle[i] = std::min(series.angle[i], other.angle[i]);
    }
}

void append(Series& series, const Element& element, const Positions& positions) {
    const auto jacobian = static_cast<float>(scaled_jacobian(element, positions));
    series.jacobian.push_back(jacobian > 0 && !is_positive(element, positions) ? -jacobian : jacobian);
    const Cosines cosines = dihedral_cosines(element, positions);
    series.angle.push_back(static_cast<float>(-std::max(cosines.largest, -cosines.smallest)));
}

Series perfect(std::size_t samples) {
    return {std::vector<float>(samples, 1.0F), std::vector<float>(samples, 1.0F)};
}

bool Rank::operator<(const Rank& other) const {
    if (positive != other.positive) return positive < other.positive;
    if (magnitude != other.magnitude) return magnitude < other.magnitude;
    const int step = angle_step(angle);
    const int other_step = angle_step(other.angle);
    if (step != other_step) return step < other_step;
    return elements > other.elements;
}

Rank rank_of(const Series& series, std::size_t elements) {
    const auto& q = series.jacobian;
    Rank rank;
    rank.elements = static_cast<int>(elements);
    rank.positive = static_cast<double>(std::count_if(q.begin(), q.end(), [](float x) { return x > 0; })) /
                    static_cast<double>(q.size());
    const double worst = *std::min_element(q.begin(), q.end());
    rank.magnitude = worst > 0 ? (std::ilogb(worst) - 1) / 2 : -1000;
    const auto uniform_end = series.angle.begin() + kUniformSamples;
    rank.angle = degrees(-quantile(std::vector<float>(series.angle.begin(), uniform_end), 0.01));
    return rank;
}

}  // namespace mortise::templates
