#include "host/improve/tips.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/common/constants.hpp"

namespace mortise::improve {
namespace {

constexpr double kReach = 1.5;  ///< cells
constexpr int kDirections = 64;
constexpr double kBranchCircle = 0.1;   ///< cells: radius of the circle on which branches are counted
constexpr std::size_t kMostTried = 64;  ///< nodes for one pole

/// A facet of the zone: a face of a tetrahedron with a tag.
struct TipFace {
    std::uint32_t tetrahedron;
    std::uint8_t face;
};

class Assigner {
  public:
    Assigner(const std::vector<Tip>& tips, const Surfaces& surfaces, Zone& zone)
        : tips_(tips), surfaces_(surfaces), zone_(zone), near_(tips.size()) {}

    bool run() {
        double largest = 0;
        for (const std::uint8_t size_class : zone_.size_class)
            largest = std::max(largest, edge_of(size_class));
        cell_ = kReach * largest;
        for (std::uint32_t i = 0; i < tips_.size(); ++i) grid_[place(tips_[i].point)].push_back(i);
        for (ZoneNode n = 0; n < zone_.points.size(); ++n) {
            if (zone_.stratum_size(n) > 0) list_near(n);
        }
        list_stars();
        bool turned = false;
        for (std::size_t i = 0; i < tips_.size(); ++i) turned = assign(i) || turned;
        return turned;
    }

  private:
    using Place = std::array<int, 3>;

    struct Candidate {
        double distance;  ///< squared
        ZoneNode node;
        bool operator<(const Candidate& other) const {
            return distance != other.distance ? distance < other.distance : node < other.node;
        }
    };

    Place place(const Point& p) const {
        Place at;
        for (std::size_t j = 0; j < 3; ++j) at[j] = static_cast<int>(std::floor(p[j] / cell_));
        return at;
    }

    void list_near(ZoneNode n) {
        const Place at = place(zone_.points[n]);
        const double reach = kReach * edge_of(zone_.size_class[n]);
        for (int k = 0; k < 27; ++k) {
            const auto found = grid_.find({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1});
            if (found == grid_.end()) continue;
            for (const std::uint32_t i : found->second) {
                const double distance = squared_length(zone_.points[n] - tips_[i].point);
                const bool fits = std::includes(tips_[i].surfaces.begin(), tips_[i].surfaces.end(),
                                                zone_.surfaces(n), zone_.surfaces(n) + zone_.stratum_size(n));
                if (fits && distance < reach * reach) near_[i].push_back({distance, n});
            }
        }
    }

    /// Facets around the nodes near poles whose surfaces take turns.
    void list_stars() {
        std::vector<std::uint8_t> wanted(zone_.points.size(), 0);
        bool any = false;
        for (std::size_t i = 0; i < tips_.size(); ++i) {
            std::sort(near_[i].begin(), near_[i].end());
            if (tips_[i].pole == nullptr) continue;
            for (const Candidate& c : near_[i]) wanted[c.node] = 1;
            any = any || !near_[i].empty();
        }
        if (!any) return;
        for (std::uint32_t i = 0; i < zone_.tetrahedra.size(); ++i) {
            const Tetrahedron& t = zone_.tetrahedra[i];
            for (std::uint8_t f = 0; f < 4; ++f) {
                if (t.tag[f] == 0 || (t.tag[f] & kTagBorder) != 0) continue;
                for (const ZoneNode n : nodes_of({i, f})) {
                    if (wanted[n] != 0) stars_[n].push_back({i, f});
                }
            }
        }
    }

    /// Ascending, so that both sides of an interface compute alike.
    std::array<ZoneNode, 3> nodes_of(TipFace face) const {
        const auto& node = zone_.tetrahedra[face.tetrahedron].node;
        const auto& o = kOpposite[face.face];
        std::array<ZoneNode, 3> n = {node[o[0]], node[o[1]], node[o[2]]};
        std::sort(n.begin(), n.end());
        return n;
    }

    bool assign(std::size_t i) {
        const Tip& tip = tips_[i];
        const auto on_all = [&](const Candidate& c) {
            return zone_.stratum_size(c.node) == tip.surfaces.size();
        };
        if (const std::size_t branches = branches_around(tip); branches > 0) {
            const std::size_t tried = std::min(near_[i].size(), kMostTried);
            for (std::size_t k = 0; k < tried; ++k) {
                if (count_branches(tip, near_[i][k].node) != branches) continue;
                zone_.tips.push_back({near_[i][k].node, tip.point});
                take_turns(tip, near_[i], near_[i][k].node);
                return true;
            }
        }
        const auto nearest = std::find_if(near_[i].begin(), near_[i].end(), on_all);
        if (nearest != near_[i].end()) zone_.tips.push_back({nearest->node, tip.point});
        return false;
    }

    /// How many creases end at a pole; 0 if the solid does not end at one surface all around it.
    std::size_t branches_around(const Tip& tip) const {
        if (tip.pole == nullptr) return 0;
        const Vec3& n = tip.pole->normal;
        const Point normal = {n[0], n[1], n[2]};
        Point u = cross(normal, std::fabs(normal[0]) < 0.6 ? Point{1, 0, 0} : Point{0, 1, 0});
        u = (1 / length(u)) * u;
        const Point v = cross(normal, u);
        std::size_t branches = 0;
        std::uint32_t before = Surfaces::kNoTurn;
        for (int k = 0; k <= kDirections; ++k) {
            const double angle = kTurn * (k % kDirections) / kDirections;
            const std::uint32_t here =
                surfaces_.turn_at(*tip.pole, tip.point + (kBranchCircle * zone_.unit) *
                                                             (std::cos(angle) * u + std::sin(angle) * v));
            if (!std::binary_search(tip.surfaces.begin(), tip.surfaces.end(), here)) return 0;
            if (k > 0 && here != before) ++branches;
            before = here;
        }
        return branches;
    }

    /// The surface that a facet has if `pole` is at the tip.
    std::uint32_t turn(const Tip& tip, TipFace face, ZoneNode pole) const {
        Point sum = {0, 0, 0};
        for (const ZoneNode n : nodes_of(face)) sum = sum + (n == pole ? tip.point : zone_.points[n]);
        return surfaces_.turn_at(*tip.pole, (1.0 / 3) * sum);
    }

    bool is_on(const Tip& tip, TipFace face) const {
        const std::uint32_t surface = tag_surface(zone_.tetrahedra[face.tetrahedron].tag[face.face]);
        return std::binary_search(tip.surfaces.begin(), tip.surfaces.end(), surface);
    }

    /// Edges of the node between facets of different surfaces, if it is at the tip.
    std::size_t count_branches(const Tip& tip, ZoneNode pole) const {
        const auto star = stars_.find(pole);
        if (star == stars_.end()) return 0;
        std::map<ZoneNode, std::uint32_t> first;
        std::size_t branches = 0;
        for (const TipFace face : star->second) {
            if (!is_on(tip, face)) return 0;
            if ((zone_.tetrahedra[face.tetrahedron].tag[face.face] & kTagInside) == 0) continue;
            const std::uint32_t surface = turn(tip, face, pole);
            if (surface == Surfaces::kNoTurn) return 0;
            for (const ZoneNode n : nodes_of(face)) {
                if (n == pole) continue;
                const auto [other, fresh] = first.emplace(n, surface);
                if (!fresh && other->second != surface) ++branches;
            }
        }
        return branches;
    }

    void take_turns(const Tip& tip, const std::vector<Candidate>& near, ZoneNode pole) {
        for (const Candidate& c : near) {
            const auto star = stars_.find(c.node);
            if (star == stars_.end()) continue;
            for (const TipFace face : star->second) {
                FaceTag& tag = zone_.tetrahedra[face.tetrahedron].tag[face.face];
                if (!is_on(tip, face)) continue;
                const std::uint32_t surface = turn(tip, face, pole);
                if (std::binary_search(tip.surfaces.begin(), tip.surfaces.end(), surface))
                    tag = make_tag(surface) | (tag & (kTagInside | kTagInterface));
            }
        }
    }

    const std::vector<Tip>& tips_;
    const Surfaces& surfaces_;
    Zone& zone_;
    double cell_ = 1;
    std::map<Place, std::vector<std::uint32_t>> grid_;  ///< tips by place
    std::vector<std::vector<Candidate>> near_;  ///< per tip: nodes on none but its surfaces, by distance
    std::map<ZoneNode, std::vector<TipFace>> stars_;
};

}  // namespace

bool assign_tips(const std::vector<Tip>& tips, const Surfaces& surfaces, Zone& zone) {
    if (tips.empty()) return false;
    return Assigner(tips, surfaces, zone).run();
}

}  // namespace mortise::improve
