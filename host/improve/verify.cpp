#include <algorithm>
#include <numeric>

#include "host/improve/block.hpp"
#include "host/improve/clash.hpp"

namespace mortise::improve {
namespace {

/// Bits of a node's number in the key of a face.
constexpr int kNodeBits = 21;

/// The three nodes of a face, ascending, in one number.
using FaceKey = std::uint64_t;
constexpr FaceKey kNoFace = ~FaceKey{0};

struct Face {
    FaceKey node = kNoFace;
    FaceTag tag = 0;
    std::uint16_t region = 0;
    bool even = false;  ///< outward order is an even permutation of the key's
    bool paired = false;
};

/// Faces without a partner and facets on one side only: what the block shows to others.
struct Border {
    FaceKey node;
    FaceTag tag;
    bool even;

    bool operator<(const Border& other) const {
        return node != other.node ? node < other.node : even < other.even;
    }
    bool operator==(const Border& other) const {
        return node == other.node && even == other.even && tag == other.tag;
    }
};

/// Faces by their nodes: open addressing, at most half full.
class FaceTable {
  public:
    explicit FaceTable(std::size_t faces) {
        while ((std::size_t{1} << bits_) < 2 * faces) ++bits_;
        table_.resize(std::size_t{1} << bits_);
    }
    Face& at(FaceKey node) {
        // Fibonacci hashing.
        std::size_t i = static_cast<std::size_t>((node * 0x9e3779b97f4a7c15u) >> (64 - bits_));
        while (table_[i].node != kNoFace && table_[i].node != node) i = (i + 1) & (table_.size() - 1);
        return table_[i];
    }
    const std::vector<Face>& all() const { return table_; }

  private:
    int bits_ = 4;
    std::vector<Face> table_;
};

bool is_pair(const Face& a, const Face& b) {
    if (a.paired || a.even == b.even || (a.tag == 0) != (b.tag == 0)) return false;
    const bool interface = a.tag != 0;
    if (interface != (a.region != b.region)) return false;
    return !interface || (a.tag ^ b.tag) == kTagInside;
}

/// Pairs the faces of the tetrahedra that `used` selects; false if one occurs where it must not.
template <class Use>
bool find_border(const std::vector<Tetrahedron>& tetrahedra, const Use& used, std::vector<Border>& border) {
    FaceTable table(4 * tetrahedra.size());
    for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
        if (!used(i)) continue;
        const Tetrahedron& t = tetrahedra[i];
        for (std::size_t f = 0; f < 4; ++f) {
            std::array<std::uint64_t, 3> n = {t.node[kOpposite[f][0]], t.node[kOpposite[f][1]],
                                              t.node[kOpposite[f][2]]};
            const bool even = sort_three(n);
            const Face face{(n[0] << (2 * kNodeBits)) | (n[1] << kNodeBits) | n[2], t.tag[f], t.region, even,
                            false};
            Face& known = table.at(face.node);
            if (known.node == kNoFace) {
                known = face;
            } else if (is_pair(known, face)) {
                known.paired = true;
            } else {
                return false;
            }
        }
    }
    for (const Face& face : table.all()) {
        // Facets of the outer boundary may change; everything else is shared with others.
        const bool is_border = face.tag == 0 || (face.tag & kTagInterface) != 0;
        if (face.node != kNoFace && !face.paired && is_border)
            border.push_back({face.node, face.tag, face.even});
    }
    std::sort(border.begin(), border.end());
    return true;
}

}  // namespace

bool Block::verify() const {
    if (points_.size() >> kNodeBits != 0) return false;  // the keys would not fit
    std::vector<Border> before;
    std::vector<Border> after;
    if (!find_border(
            original_, [](std::size_t) { return true; }, before))
        return false;
    if (!find_border(
            tetrahedra_, [&](std::size_t i) { return alive_[i] != 0; }, after))
        return false;
    if (before != after) return false;
    const double same = kSameNode * unit_;
    std::vector<Local> order;
    for (Local n = 0; n < points_.size(); ++n) {
        if (!star_[n].empty() || !pyramid_star_[n].empty()) order.push_back(n);
    }
    std::sort(order.begin(), order.end(), [&](Local a, Local b) { return points_[a] < points_[b]; });
    for (std::size_t i = 0; i < order.size(); ++i) {
        for (std::size_t j = i + 1; j < order.size(); ++j) {
            const Point d = points_[order[j]] - points_[order[i]];
            if (d[0] > same) break;
            if (squared_length(d) < same * same) return false;
        }
    }
    return true;
}

}  // namespace mortise::improve
