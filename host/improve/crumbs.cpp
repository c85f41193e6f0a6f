#include "host/improve/crumbs.hpp"

#include <algorithm>

#include "host/common/disjoint_sets.hpp"
#include "host/common/parallel.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kCrumbChunk = 8192;

struct CrumbFace {
    std::array<ZoneNode, 3> node;  ///< ascending
    std::uint32_t owner;
    bool operator<(const CrumbFace& other) const { return node < other.node; }
};

/// In smallest leaves around the tetrahedron.
double volume(const Zone& zone, const Tetrahedron& t) {
    const std::array<Point, 4> p = {zone.points[t.node[0]], zone.points[t.node[1]], zone.points[t.node[2]],
                                    zone.points[t.node[3]]};
    double edge = edge_of(zone.size_class[t.node[0]]);
    for (const ZoneNode n : t.node) edge = std::min(edge, edge_of(zone.size_class[n]));
    return dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])) / (6 * edge * edge * edge);
}

/// Whether two faces at least are facets with nothing behind them: so are elements of scraps, but the
/// smallest.
bool is_bare(const Tetrahedron& t) {
    const auto is_bare_face = [](FaceTag tag) {
        return tag != 0 && (tag & (kTagInterface | kTagBorder)) == 0;
    };
    return std::count_if(t.tag.begin(), t.tag.end(), is_bare_face) >= 2;
}

/// Tetrahedra that are small enough, in order.
std::vector<std::uint32_t> find_small(const Zone& zone, double most, int threads) {
    const std::size_t count = zone.tetrahedra.size();
    std::vector<std::vector<std::uint32_t>> found(chunk_count(count, kCrumbChunk));
    parallel_chunks(count, kCrumbChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const Tetrahedron& t = zone.tetrahedra[i];
            if (volume(zone, t) > (is_bare(t) ? most : kCrumbVolume)) continue;
            found[begin / kCrumbChunk].push_back(static_cast<std::uint32_t>(i));
        }
    });
    std::vector<std::uint32_t> small;
    for (const auto& list : found) small.insert(small.end(), list.begin(), list.end());
    return small;
}

/// Pieces of small tetrahedra, joined by faces: each known by its first.
class SmallPieces {
  public:
    SmallPieces(const Zone& zone, const std::vector<std::uint32_t>& small, double most)
        : zone_(zone), small_(small), most_(most), sets_(small.size()) {
        std::vector<std::uint8_t> held(small.size(), 0);
        join_by_faces(held);
        attached_.assign(small.size(), 0);
        volume_.assign(small.size(), 0);
        for (std::uint32_t i = 0; i < small.size(); ++i) {
            attached_[sets_.find(i)] |= held[i];
            volume_[sets_.find(i)] += volume(zone, zone.tetrahedra[small[i]]);
        }
        find_hanging();
    }

    bool is_left_out(std::uint32_t i) {
        const std::uint32_t first = sets_.find(i);
        return is_loose(i) && (volume_[first] <= kCrumbVolume || hangs_[first] != 0);
    }
    double volume_of(std::uint32_t i) { return volume_[sets_.find(i)]; }
    bool is_first(std::uint32_t i) const { return sets_.is_first(i); }

  private:
    /// Whether it shares faces with nothing, and is small altogether.
    bool is_loose(std::uint32_t i) {
        const std::uint32_t first = sets_.find(i);
        return attached_[first] == 0 && volume_[first] <= most_;
    }

    /// Per node of the zone, whether something has it that is not among the loose ones (places in small_).
    std::vector<std::uint8_t> nodes_of_others(const std::vector<std::uint32_t>& loose) const {
        std::vector<std::uint8_t> used = zone_.frozen;
        auto next = loose.begin();
        for (std::uint32_t i = 0; i < zone_.tetrahedra.size(); ++i) {
            if (next != loose.end() && small_[*next] == i) {
                ++next;
                continue;
            }
            for (const ZoneNode n : zone_.tetrahedra[i].node) used[n] = 1;
        }
        for (const Pyramid& p : zone_.pyramids) {
            for (const ZoneNode n : p.node) used[n] = 1;
        }
        return used;
    }

    /// Finds the loose pieces with a node of something that is not loose, or of another that hangs.
    void find_hanging() {
        hangs_.assign(small_.size(), 0);
        std::vector<std::uint32_t> loose;  // places in small_
        for (std::uint32_t i = 0; i < small_.size(); ++i) {
            if (is_loose(i)) loose.push_back(i);
        }
        if (loose.empty()) return;
        std::vector<std::uint8_t> used = nodes_of_others(loose);
        for (bool found = true; found;) {
            found = false;
            for (const std::uint32_t i : loose) {
                const auto& node = zone_.tetrahedra[small_[i]].node;
                if (hangs_[sets_.find(i)] != 0 ||
                    std::none_of(node.begin(), node.end(), [&](ZoneNode n) { return used[n] != 0; }))
                    continue;
                hangs_[sets_.find(i)] = 1;
                found = true;
            }
            for (const std::uint32_t i : loose) {
                if (hangs_[sets_.find(i)] == 0) continue;
                for (const ZoneNode n : zone_.tetrahedra[small_[i]].node) used[n] = 1;
            }
        }
    }

    /// Sets `held` where a face belongs to something that is not small, or must stay.
    void join_by_faces(std::vector<std::uint8_t>& held) {
        std::vector<CrumbFace> faces;
        for (std::uint32_t i = 0; i < small_.size(); ++i) {
            const Tetrahedron& t = zone_.tetrahedra[small_[i]];
            for (std::size_t f = 0; f < 4; ++f) {
                held[i] |= (t.tag[f] & kTagBorder) != 0 ? 1 : 0;
                if (t.tag[f] != 0 && (t.tag[f] & kTagInterface) == 0) continue;
                const auto& o = kOpposite[f];
                CrumbFace face{{t.node[o[0]], t.node[o[1]], t.node[o[2]]}, i};
                sort_three(face.node);
                faces.push_back(face);
            }
        }
        std::sort(faces.begin(), faces.end());
        for (std::size_t i = 0; i < faces.size(); ++i) {
            if (i + 1 < faces.size() && faces[i + 1].node == faces[i].node) {
                sets_.join(faces[i].owner, faces[i + 1].owner);
                ++i;
            } else {
                held[faces[i].owner] = 1;
            }
        }
        std::vector<std::uint8_t> is_tip(zone_.points.size(), 0);
        for (const auto& tip : zone_.tips) is_tip[tip.first] = 1;
        for (std::uint32_t i = 0; i < small_.size(); ++i) {
            const auto& node = zone_.tetrahedra[small_[i]].node;
            held[i] |=
                std::any_of(node.begin(), node.end(), [&](ZoneNode n) { return is_tip[n] != 0; }) ? 1 : 0;
        }
    }

    const Zone& zone_;
    const std::vector<std::uint32_t>& small_;
    const double most_;                   ///< volume of a piece that may be left out
    DisjointSets sets_;                   ///< of places in small_
    std::vector<std::uint8_t> attached_;  ///< per set
    std::vector<double> volume_;          ///< per set
    std::vector<std::uint8_t> hangs_;     ///< per set
};

}  // namespace

Crumbs remove_crumbs(Zone& zone, double most, int threads) {
    Crumbs crumbs;
    const std::vector<std::uint32_t> small = find_small(zone, most, threads);
    if (small.empty()) return crumbs;
    SmallPieces pieces(zone, small, most);
    std::vector<std::uint32_t> gone;
    for (std::uint32_t i = 0; i < small.size(); ++i) {
        if (!pieces.is_left_out(i)) continue;
        gone.push_back(small[i]);
        if (!pieces.is_first(i)) continue;
        if (crumbs.count++ == 0) crumbs.first = zone.points[zone.tetrahedra[small[i]].node[0]];
        crumbs.largest = std::max(crumbs.largest, pieces.volume_of(i));
    }
    std::size_t to = 0;
    auto next = gone.begin();
    for (std::uint32_t i = 0; i < zone.tetrahedra.size(); ++i) {
        if (next != gone.end() && *next == i)
            ++next;
        else
            zone.tetrahedra[to++] = zone.tetrahedra[i];
    }
    zone.tetrahedra.resize(to);
    return crumbs;
}

}  // namespace mortise::improve
