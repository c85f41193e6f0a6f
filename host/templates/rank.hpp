// How candidates for a template are compared.
//
// In this order: the share of samples with every element positive; the worst scaled Jacobian, by its order of
// magnitude (where the surface nearly touches a corner it tends to 0 for every template); the 1 % quantile of
// the dihedral angles over uniform samples, in steps of 10 %; the number of elements, fewer being better.
#pragma once

#include <vector>

#include "host/templates/measure.hpp"
#include "host/templates/pattern.hpp"

namespace mortise::templates {

/// The first samples of a search are uniform; the others probe validity at extreme cuts.
inline constexpr int kUniformSamples = 800;
inline constexpr int kExtremeSamples = 400;
inline constexpr int kIndependentSamples = 400;

/// Quality of one element, or of the worst of several, at each sample.
struct Series {
    std::vector<float> jacobian;  ///< scaled Jacobian, <= 0 where the element is not positive everywhere
    /// Of min(smallest, 180 - largest dihedral) the cosine, negated: larger is better.
    std::vector<float> angle;
};

double quantile(std::vector<float> values, double fraction);
Series perfect(std::size_t samples);
void append(Series& series, const Element& element, const Positions& positions);
void lower(Series& series, const Series& other);  ///< to the smaller of the two at each sample

struct Rank {
    double positive = 0;
    int magnitude = 0;  ///< of the worst scaled Jacobian: floor(log4)
    double angle = 0;   ///< degrees
    int elements = 0;

    bool operator<(const Rank& other) const;
};

/// Falls when elements are added. Precondition: at least kUniformSamples samples.
Rank rank_of(const Series& series, std::size_t elements);

struct Candidate {
    std::vector<Element> elements;
    NodeSet interior_mean = 0;  ///< 0: no interior node
    Rank rank;
};

}  // namespace mortise::templates
