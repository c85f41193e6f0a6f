#include "host/layers/growth.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/common/message_text.hpp"
#include "host/common/parallel.hpp"
#include "host/common/small_groups.hpp"
#include "host/common/vec3.hpp"
#include "mortise/error.hpp"

namespace mortise::layers {
namespace {

/// Where heights follow the wall's edges: the last layer's to these, and the most that all reach; the most
/// that they reach if somebody asks for more.
constexpr double kLastHeight = 0.4, kMostReach = 1, kMostAsked = 8;
/// The thinnest layer, of the mesh's extent.
constexpr double kThinnest = 1e-9;
constexpr int kSmoothings = 10;  ///< of the edges' lengths

/// Cosine between the direction and a facet's normal: that of a direction which is good enough, the least at
/// which layers leave the wall, and that to which they reach farther to be as thick as elsewhere.
constexpr double kUpright = 0.9, kLeastUpright = 0.1, kLengthened = 0.5;

constexpr double kSameNormal = 1e-6;
constexpr double kOtherWay = 0.4;         ///< sine of the angle between normals of a smooth wall, at most
constexpr std::size_t kMostNormals = 16;  ///< beyond that the worst pair decides

/// Normals into the solid of the wall's facets at a node, each once, and the facets' mean one.
struct Normals {
    std::vector<Vec3> each;
    Vec3 mean{};
};

Normals normals_at(const Mesh& mesh, const Walls& walls, NodeId node, const SmallGroups::Group& facets) {
    Normals normals;
    for (const std::uint32_t f : facets) {
        const WallFacet& facet = walls.facets[f];
        const std::size_t corners = facet.corners();
        std::size_t k = 0;
        while (facet.node[k] != node) ++k;
        const Vec3 at = point_of(mesh, node);
        const Vec3 next = unit(difference(point_of(mesh, facet.node[(k + 1) % corners]), at));
        const Vec3 before = unit(difference(point_of(mesh, facet.node[(k + corners - 1) % corners]), at));
        const Vec3 across = cross(before, next);
        const double angle = std::atan2(length(across), dot(before, next));
        const Vec3 normal = unit(across);
        normals.mean = sum(normals.mean, scaled(normal, angle));
        const bool is_known = std::any_of(normals.each.begin(), normals.each.end(), [&](const Vec3& other) {
            return squared_length(difference(normal, other)) < kSameNormal * kSameNormal;
        });
        if (!is_known) normals.each.push_back(normal);
    }
    return normals;
}

/// A direction and the least cosine between it and the normals.
struct Choice {
    Vec3 direction{};
    double upright = -2;
};

/// Takes the best of directions that are offered, the first of equals.
class Best {
  public:
    explicit Best(const std::vector<Vec3>& normals) : normals_(normals) {}

    void offer(const Vec3& way) {
        const Vec3 direction = unit(way);
        double upright = 1;
        for (const Vec3& normal : normals_) upright = std::min(upright, dot(direction, normal));
        if (upright > best_.upright) best_ = {direction, upright};
    }
    void offer_both(const Vec3& way) {
        offer(way);
        offer(scaled(way, -1));
    }
    const Choice& best() const { return best_; }

  private:
    const std::vector<Vec3>& normals_;
    Choice best_;
};

/// The axis of the narrowest cone around all normals, of the directions that stay on the node's surfaces:
/// one, two or three normals lie on that cone.
Choice choose_direction(const Normals& normals, const Across& slide) {
    Best best(normals.each);
    if (slide.count == 3) return best.best();
    if (slide.count == 2) {
        best.offer_both(cross(slide.normal[0], slide.normal[1]));
        return best.best();
    }
    const auto flat = [&](const Vec3& v) {
        return slide.count == 0 ? v : difference(v, scaled(slide.normal[0], dot(v, slide.normal[0])));
    };
    best.offer(flat(normals.mean));
    if (best.best().upright >= kUpright) return best.best();
    const std::size_t count = std::min(normals.each.size(), kMostNormals);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3& a = normals.each[i];
        best.offer(flat(a));
        for (std::size_t j = 0; j < i; ++j) {
            const Vec3& b = normals.each[j];
            if (slide.count == 1) {
                best.offer_both(cross(slide.normal[0], difference(a, b)));
                continue;
            }
            best.offer(sum(a, b));
            for (std::size_t k = 0; k < j; ++k) {
                const Vec3& c = normals.each[k];
                best.offer_both(cross(difference(b, a), difference(c, a)));
            }
        }
    }
    return best.best();
}

/// Directions in which layers' heights lie: across the wall's facets, which are one where they are alike, and
/// across the surfaces that the node slides on.
Across heights_across(const Normals& normals, const Across& slide) {
    Across across = slide;
    const auto add_most_different = [&] {
        const Vec3* most = &normals.each.front();
        for (const Vec3& normal : normals.each) {
            if (length(across.free_part(normal)) > length(across.free_part(*most))) most = &normal;
        }
        return across.add(*most, kOtherWay);
    };
    const bool is_smooth = std::all_of(normals.each.begin(), normals.each.end(), [&](const Vec3& normal) {
        return length(cross(normal, unit(normals.mean))) < kOtherWay;
    });
    if (is_smooth) {
        across.add(unit(normals.mean), kSameNormal);
    } else {
        while (add_most_different()) {
        }
    }
    return across;
}

/// Mean length of the edges at each wall node, levelled out.
std::vector<double> edge_lengths(const Mesh& mesh, const Walls& walls, const SmallGroups& facets_at,
                                 int threads) {
    const std::size_t count = walls.nodes.size();
    // Calls visit(place of a neighbour) for both ends of a facet's edges at the node.
    const auto for_neighbours = [&](std::size_t place, const auto& visit) {
        for (const std::uint32_t f : facets_at[place]) {
            const WallFacet& facet = walls.facets[f];
            const std::size_t corners = facet.corners();
            std::size_t k = 0;
            while (facet.node[k] != walls.nodes[place]) ++k;
            visit(walls.place[facet.node[(k + 1) % corners]]);
            visit(walls.place[facet.node[(k + corners - 1) % corners]]);
        }
    };
    std::vector<double> lengths(count), next(count);
    for (int round = 0; round <= kSmoothings; ++round) {
        parallel_chunks(count, kNodeChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                double total = 0, weight = 0;
                for_neighbours(i, [&](std::uint32_t neighbour) {
                    const Vec3 way =
                        difference(point_of(mesh, walls.nodes[neighbour]), point_of(mesh, walls.nodes[i]));
                    total += round == 0 ? length(way) : lengths[neighbour];
                    ++weight;
                });
                next[i] = total / weight;
            }
        });
        lengths.swap(next);
    }
    return lengths;
}

double extent_of(const Mesh& mesh) {
    double extent = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        double low = mesh.points[j], high = low;
        for (std::size_t i = j; i < mesh.points.size(); i += 3) {
            low = std::min(low, mesh.points[i]);
            high = std::max(high, mesh.points[i]);
        }
        extent = std::max(extent, high - low);
    }
    return extent;
}

void check_thinnest(const Mesh& mesh, const Heights& heights, const Growth& growth) {
    if (growth.height.empty()) return;
    const double least = *std::min_element(growth.height.begin(), growth.height.end());
    const double thinnest =
        least / heights.sum(heights.count) * std::min(1.0, std::pow(heights.growth, heights.count - 1));
    const double extent = extent_of(mesh);
    if (thinnest >= kThinnest * extent) return;
    throw Error(
        ExitCode::kUsage,
        "the thinnest of " + std::to_string(heights.count) + " layers would be " + rounded_text(thinnest, 3) +
            " high in a mesh that is " + rounded_text(extent, 3) +
            " long, too little to tell its nodes apart; ask for fewer layers, higher ones, or a growth "
            "nearer to 1");
}

/// Bare ends of rims where the layers' sides would not continue the facet, but cover it, or stand in the
/// solid.
void look_at_rims(const Mesh& mesh, Growth& growth, Walls& walls) {
    std::vector<std::uint32_t> bare;
    for (const Rim& rim : walls.rims) {
        const NodeId* const node = mesh.facets.nodes.data() + 4 * std::size_t{rim.facet};
        const Vec3 normal = unit(cross(difference(point_of(mesh, node[2]), point_of(mesh, node[0])),
                                       difference(point_of(mesh, node[3]), point_of(mesh, node[1]))));
        const Vec3 edge = unit(difference(point_of(mesh, rim.b), point_of(mesh, rim.a)));
        for (const NodeId end : {rim.a, rim.b}) {
            const Vec3& reach = growth.reach[walls.place[end]];
            if (squared_length(reach) > 0 && dot(cross(edge, unit(reach)), normal) < kLeastUpright)
                bare.insert(bare.end(), {walls.place[rim.a], walls.place[rim.b]});
        }
    }
    for (const std::uint32_t place : bare) {
        walls.is_bare[place] = 1;
        growth.reach[place] = {};
        growth.fixed[place] = {{}, 3};
    }
}

}  // namespace

double Heights::sum(int layers) const {
    double height = 1, total = 0;
    for (int k = 0; k < layers; ++k, height *= growth) total += height;
    return total;
}

Growth find_growth(const Mesh& mesh, const Slides& slides, const Heights& heights, int threads,
                   Walls& walls) {
    const std::size_t count = walls.nodes.size();
    const SmallGroups facets_at(count, [&](const auto& found) {
        for (std::size_t f = 0; f < walls.facets.size(); ++f) {
            for (std::size_t k = 0; k < walls.facets[f].corners(); ++k)
                found(walls.place[walls.facets[f].node[k]], f);
        }
    });
    Growth growth;
    growth.edges = edge_lengths(mesh, walls, facets_at, threads);
    growth.reach.resize(count);
    growth.height.resize(count);
    growth.asked.resize(count);
    growth.fixed.resize(count, {{}, 3});
    const double all = heights.sum(heights.count);
    const double last = std::pow(heights.growth, heights.count - 1);
    parallel_chunks(count, kNodeChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            growth.asked[i] = heights.first > 0
                                  ? heights.first * all
                                  : growth.edges[i] * std::min(kLastHeight * all / last, kMostReach);
            growth.height[i] = std::min(growth.asked[i], kMostAsked * growth.edges[i]);
            if (walls.is_bare[i] != 0) continue;
            const NodeId node = walls.nodes[i];
            const Normals normals = normals_at(mesh, walls, node, facets_at[i]);
            const Choice choice = choose_direction(normals, slides.across(node));
            if (choice.upright < kLeastUpright) {
                walls.is_bare[i] = 1;
                continue;
            }
            growth.fixed[i] = heights_across(normals, slides.across(node));
            const Vec3 reach =
                scaled(choice.direction, growth.height[i] / std::max(choice.upright, kLengthened));
            growth.reach[i] = difference(reach, growth.fixed[i].free_part(reach));
        }
    });
    check_thinnest(mesh, heights, growth);
    look_at_rims(mesh, growth, walls);
    return growth;
}

}  // namespace mortise::layers
