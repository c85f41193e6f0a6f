// Medians and spreads; see statistics.hpp.
#include "bench/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace mortise::bench {

double Samples::median() const {
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t middle = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

double Samples::low() const { return *std::min_element(values.begin(), values.end()); }

double Samples::high() const { return *std::max_element(values.begin(), values.end()); }

double Samples::spread() const { return (high() - low()) / median(); }

nlohmann::json to_json(const Samples& samples) {
    return {{"median", samples.median()},
            {"low", samples.low()},
            {"high", samples.high()},
            {"samples", samples.values}};
}

Samples collect(const nlohmann::json& runs, const char* field) {
    Samples samples;
    for (const nlohmann::json& run : runs) samples.values.push_back(run.at(field).get<double>());
    return samples;
}

double growth_exponent(const std::vector<double>& x, const std::vector<double>& y) {
    double mean_x = 0;
    double mean_y = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        mean_x += std::log(x[i]) / static_cast<double>(x.size());
        mean_y += std::log(y[i]) / static_cast<double>(x.size());
    }
    double above = 0;
    double below = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double dx = std::log(x[i]) - mean_x;
        above += dx * (std::log(y[i]) - mean_y);
        below += dx * dx;
    }
    return above / below;
}

}  // namespace mortise::bench
