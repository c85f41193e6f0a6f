// Search for templates; see search.hpp for the method, rank.hpp for the choice among candidates.
#include "host/templates/search.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "host/templates/rank.hpp"
#include "host/templates/tiling.hpp"

namespace mortise::templates {
namespace {

/// A cone must be better, and its angles by a quarter or its validity at all, to be worth its interior node.
bool is_worth_a_node(const Rank& cone, const Rank& tiling) {
    constexpr double kInteriorGain = 1.25;
    return tiling < cone && (tiling.positive < cone.positive || tiling.angle * kInteriorGain < cone.angle);
}

void sort_by_type(std::vector<Element>& elements) {
    std::stable_sort(elements.begin(), elements.end(),
                     [](const Element& a, const Element& b) { return a.type < b.type; });
}

/// Node sets that the pattern's own symmetries leave unchanged, as unions of orbits.
std::vector<NodeSet> symmetric_sets(Pattern pattern) {
    std::vector<NodeSet> orbits;
    NodeSet done = 0;
    for (const NodeCode node : node_list(pattern_nodes(pattern))) {
        if ((done >> node & 1U) != 0) continue;
        NodeSet orbit = 0;
        for (const Symmetry& symmetry : symmetries()) {
            if (mapped(pattern, symmetry) == pattern) orbit |= 1U << symmetry.image[node];
        }
        done |= orbit;
        orbits.push_back(orbit);
    }
    std::vector<NodeSet> sets;
    for (std::uint32_t choice = 1; choice < 1U << orbits.size(); ++choice) {
        NodeSet set = 0;
        for (std::size_t i = 0; i < orbits.size(); ++i) set |= (choice >> i & 1U) != 0 ? orbits[i] : 0;
        if (bits(set) >= 4) sets.push_back(set);
    }
    return sets;
}

Element cone_element(const Facet& facet) {
    const Facet base = reversed(facet);  // seen from the apex: counter-clockwise
    const auto& n = base.nodes;
    if (facet.size == 4) return {ElementType::kPyramid, {n[0], n[1], n[2], n[3], kInteriorNode}};
    return {ElementType::kTetrahedron, {n[0], n[1], n[2], kInteriorNode}};
}

/// All cones of one mean; elements over one facet are measured once for all surfaces.
class Cones {
  public:
    Cones(std::vector<Positions> positions, NodeSet mean_of)
        : mean_of_(mean_of), positions_(std::move(positions)) {
        for (Positions& p : positions_) p[kInteriorNode] = mean(p, mean_of);
    }
    Candidate cone(const std::vector<Facet>& boundary) {
        Candidate candidate;
        candidate.interior_mean = mean_of_;
        Series quality = perfect(positions_.size());
        for (const Facet& facet : boundary) {
            const Element element = cone_element(facet);
            Series& series = known_[facet_key(facet)];
            if (series.jacobian.empty()) {
                for (const Positions& p : positions_) append(series, element, p);
            }
            candidate.elements.push_back(element);
            lower(quality, series);
        }
        candidate.rank = rank_of(quality, candidate.elements.size());
        return candidate;
    }

  private:
    NodeSet mean_of_;
    std::vector<Positions> positions_;
    std::map<std::uint32_t, Series> known_;
};

/// Uniform planes, then planes that almost touch a corner, then independent cuts, as of curved surfaces.
std::vector<Positions> search_positions(Pattern pattern) {
    Random random(977);
    const Pattern pair = std::min(pattern, static_cast<Pattern>(~pattern));
    std::vector<Positions> positions = measured_positions(pair, 978, kUniformSamples);
    for (int i = 0; i < kExtremeSamples && is_separable(pattern); ++i) {
        positions.push_back(plane_positions(pair, extreme_plane(pair, random), kCutMargin));
    }
    for (int i = 0; i < kIndependentSamples; ++i) {
        positions.push_back(independent_positions(pair, 0.05, 0.95, random));
    }
    return positions;
}

/// Best candidate of one pattern for each surface.
std::vector<Candidate> best_candidates(Pattern pattern, const std::vector<std::vector<Facet>>& surfaces,
                                       const std::vector<Positions>& positions) {
    std::vector<Cones> cones;
    for (const NodeSet set : symmetric_sets(pattern)) cones.emplace_back(positions, set);
    std::vector<std::vector<Facet>> boundaries;
    for (const auto& surface : surfaces) boundaries.push_back(inside_boundary(pattern, surface));
    auto tilings = best_tilings(pattern, is_separable(pattern), boundaries, positions);
    std::vector<Candidate> result;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        std::optional<Candidate> best;
        for (Cones& each : cones) {
            Candidate candidate = each.cone(boundaries[i]);
            if (!best || best->rank < candidate.rank) best = std::move(candidate);
        }
        if (tilings[i] && (!best || !is_worth_a_node(best->rank, tilings[i]->rank)))
            best = std::move(tilings[i]);
        sort_by_type(best->elements);
        result.push_back(std::move(*best));
    }
    return result;
}

}  // namespace

bool is_separable(Pattern pattern) {
    if (!is_simple(pattern)) return false;
    if (bits(pattern) != 4 || surface_loop(pattern).size() == 4) return true;
    // Of the two shapes with four inside corners and six cuts, the tripod has a corner with three inside
    // neighbours, the chain has none.
    for (int c = 0; c < kCorners; ++c) {
        const int neighbours = (pattern >> (c ^ 1) & 1) + (pattern >> (c ^ 2) & 1) + (pattern >> (c ^ 4) & 1);
        if ((pattern >> c & 1) != 0 && neighbours == 3) return true;
    }
    return false;
}

std::vector<Positions> measured_positions(Pattern pattern, std::uint64_t seed, int count) {
    Random random(seed);
    std::vector<Positions> positions;
    const Pattern pair = std::min(pattern, static_cast<Pattern>(~pattern));
    for (int i = 0; i < count; ++i) {
        positions.push_back(is_separable(pattern)
                                ? plane_positions(pair, random_plane(pair, random), kCutMargin)
                                : independent_positions(pair, 0.2, 0.8, random));
    }
    return positions;
}

Score measure(const Template& candidate, const std::vector<Positions>& positions) {
    std::vector<float> jacobians;
    std::vector<float> angles;
    Cosines extremes;
    int positive = 0;
    for (Positions p : positions) {
        if (candidate.interior_mean != 0) p[kInteriorNode] = mean(p, candidate.interior_mean);
        float quality = 1;
        Cosines cosines;
        bool all_positive = true;
        for (const Element& element : candidate.elements) {
            quality = std::min(quality, static_cast<float>(scaled_jacobian(element, p)));
            all_positive = all_positive && is_positive(element, p);
            const Cosines here = dihedral_cosines(element, p);
            cosines.smallest = std::min(cosines.smallest, here.smallest);
            cosines.largest = std::max(cosines.largest, here.largest);
        }
        positive += all_positive ? 1 : 0;
        jacobians.push_back(quality);
        angles.push_back(
            static_cast<float>(std::min(degrees(cosines.largest), 180 - degrees(cosines.smallest))));
        extremes.smallest = std::min(extremes.smallest, cosines.smallest);
        extremes.largest = std::max(extremes.largest, cosines.largest);
    }
    Score score;
    score.positive = static_cast<double>(positive) / static_cast<double>(positions.size());
    score.worst_jacobian = *std::min_element(jacobians.begin(), jacobians.end());
    score.low_jacobian = quantile(jacobians, 0.01);
    score.worst_angle = *std::min_element(angles.begin(), angles.end());
    score.low_angle = quantile(angles, 0.01);
    score.smallest_dihedral = degrees(extremes.largest);
    score.largest_dihedral = degrees(extremes.smallest);
    return score;
}

std::vector<Facet> inside_boundary(Pattern pattern, const std::vector<Facet>& surface) {
    std::vector<Facet> boundary = surface;
    for (int f = 0; f < kFaces; ++f) {
        const std::vector<Facet> mesh = face_mesh(pattern, f);
        boundary.insert(boundary.end(), mesh.begin(), mesh.end());
    }
    return boundary;
}

TemplatePair find_templates(Pattern pattern) {
    const auto complement = static_cast<Pattern>(~pattern);
    const std::vector<std::vector<Facet>> surfaces = dissections(surface_loop(pattern));
    std::vector<std::vector<Facet>> turned = surfaces;
    for (auto& surface : turned) {
        for (Facet& facet : surface) facet = reversed(facet);
    }
    const std::vector<Positions> positions = search_positions(pattern);
    const std::vector<Candidate> insides = best_candidates(pattern, surfaces, positions);
    const std::vector<Candidate> complements = best_candidates(complement, turned, positions);
    std::size_t best = 0;
    const auto worse_of = [&](std::size_t i) { return std::min(insides[i].rank, complements[i].rank); };
    const auto better_of = [&](std::size_t i) { return std::max(insides[i].rank, complements[i].rank); };
    for (std::size_t i = 1; i < surfaces.size(); ++i) {
        const bool tied = !(worse_of(best) < worse_of(i)) && !(worse_of(i) < worse_of(best));
        if (worse_of(best) < worse_of(i) || (tied && better_of(best) < better_of(i))) best = i;
    }
    TemplatePair pair;
    pair.inside = {insides[best].elements, insides[best].interior_mean, surfaces[best], {}};
    pair.complement = {complements[best].elements, complements[best].interior_mean, turned[best], {}};
    return pair;
}

}  // namespace mortise::templates
