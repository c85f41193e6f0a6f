// Films keep their thickness.
//
// A facet whose nodes lie on a curved surface does not: it is a chord. Between two curved surfaces a
// thousandth of a cell apart, chords on one side alone make the solid several times as thick, and what is
// thicker has better elements. So every element knows its share of the volume that was there when its zone
// was opened, shares are handed on whenever elements are replaced, and no change of facets may give a region
// notably more room than its share. In bodies as thick as their elements chords never reach that.
#include <algorithm>
#include <utility>

#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

constexpr double kMostSwelling = 1.1;         ///< volume per share, of elements that are changed
constexpr double kMostSwellingAround = 1.05;  ///< and together with those that touch them
constexpr double kSameVolume = 1 + 1e-6;

}  // namespace

double Block::volume(const Tetrahedron& t) const {
    const Point& a = points_[t.node[0]];
    return tetrahedron_volume(a, points_[t.node[1]], points_[t.node[2]], points_[t.node[3]]);
}

void Block::add_share(std::uint16_t region, double volume, double share, std::vector<Room>& rooms) {
    auto room = std::find_if(rooms.begin(), rooms.end(), [&](const Room& r) { return r.region == region; });
    if (room == rooms.end()) room = rooms.insert(room, {region, 0, 0});
    room->volume += volume;
    room->share += share;
}

void Block::add_room(const Tetrahedron& t, std::vector<Room>& rooms) const {
    add_share(t.region, volume(t), t.share, rooms);
}

/// Whether facets of nodes with this stratum can be chords: others give no room away while their nodes stay
/// on their surfaces.
bool Block::is_curved(const std::vector<std::uint32_t>& stratum) const {
    return std::any_of(stratum.begin(), stratum.end(), [this](std::uint32_t s) { return !is_plane(s); });
}

/// The room of the elements around a node.
void Block::gather_room(Local node, std::vector<Room>& rooms) const {
    rooms.clear();
    for (const std::uint32_t i : star_[node]) add_room(tetrahedra_[i], rooms);
}

/// Whether a region has got more room than it had, and than it should have.
bool Block::has_swollen(const std::vector<Room>& before, const std::vector<Room>& after, double most) {
    return std::any_of(after.begin(), after.end(), [&](const Room& now) {
        const auto old =
            std::find_if(before.begin(), before.end(), [&](const Room& r) { return r.region == now.region; });
        return old != before.end() && now.volume > std::max(kSameVolume * old->volume, most * old->share);
    });
}

/// Whether a change of these elements, from room_before_ to room_after_, makes them swell, and still does if
/// all that touch them count, too: slivers on the skin of a thick body may swell.
bool Block::have_swollen(const std::vector<std::uint32_t>& changed) {
    if (!has_swollen(room_before_, room_after_, kMostSwelling)) return false;
    counted_.resize(tetrahedra_.size(), 0);
    counted_node_.resize(points_.size(), 0);
    ++count_;
    for (const std::uint32_t i : changed) counted_[i] = count_;
    for (const std::uint32_t i : changed) {
        for (const Local n : tetrahedra_[i].node) {
            if (std::exchange(counted_node_[n], count_) == count_) continue;
            for (const std::uint32_t near : star_[n]) {
                if (std::exchange(counted_[near], count_) == count_) continue;
                const Tetrahedron& t = tetrahedra_[near];
                const double own = volume(t);
                add_share(t.region, own, t.share, room_before_);
                add_share(t.region, own, t.share, room_after_);
            }
        }
    }
    return has_swollen(room_before_, room_after_, kMostSwellingAround);
}

bool Block::swells(const Change& change) {
    room_before_.clear();
    room_after_.clear();
    for (const std::uint32_t i : change.removed) add_room(tetrahedra_[i], room_before_);
    for (const Tetrahedron& t : change.added) add_room(t, room_after_);
    return have_swollen(change.removed);
}

/// The same for a node that has moved; start_room_ is what its elements had before.
bool Block::star_swells(Local node) {
    room_before_ = start_room_;
    gather_room(node, room_after_);
    return have_swollen(star_[node]);
}

/// Divides the share of what goes among what comes, by volume.
void Block::hand_on_shares(Change& change) {
    room_after_.clear();
    for (const std::uint32_t i : change.removed)
        add_share(tetrahedra_[i].region, 0, tetrahedra_[i].share, room_after_);
    for (const Tetrahedron& t : change.added) add_share(t.region, volume(t), 0, room_after_);
    for (Tetrahedron& t : change.added) t.share = share_of(t, room_after_);
}

/// The same among the elements around a node that has moved.
void Block::divide_shares(Local node) {
    gather_room(node, room_after_);
    for (const std::uint32_t i : star_[node]) tetrahedra_[i].share = share_of(tetrahedra_[i], room_after_);
}

double Block::share_of(const Tetrahedron& t, const std::vector<Room>& rooms) const {
    const auto room =
        std::find_if(rooms.begin(), rooms.end(), [&](const Room& r) { return r.region == t.region; });
    return room->share * (volume(t) / room->volume);
}

}  // namespace mortise::improve
