// Medians and spreads of repeated measurements, and the growth of one quantity with another.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

namespace mortise::bench {

/// Repeated measurements of one quantity; at least one value.
struct Samples {
    std::vector<double> values;

    double median() const;
    double low() const;
    double high() const;
    /// Range of the values as a share of their median.
    double spread() const;
};

/// {"median", "low", "high", "samples"}.
nlohmann::json to_json(const Samples& samples);

/// The values of `field` in a list of measured runs.
Samples collect(const nlohmann::json& runs, const char* field);

/// Exponent k of y ~ x^k: the slope of the least-squares line through the logarithms. Needs two different x.
double growth_exponent(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace mortise::bench
