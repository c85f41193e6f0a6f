// Two surfaces that go on from each other at a third one (host/octree/tangent.hpp) as one surface of the
// cell, in all entities whose NIO leaves all have that joint. On others the leaf beside knows one of the two,
// and the third has one sign there; or it knows all three, and both cells take them one by one. What a cell's
// last surface stands for, the joint's or all of a crowded cell (crowd.cpp), is asked here.
#include <algorithm>

#include "host/cnio/cell.hpp"

namespace mortise::cnio {

/// Adds the joint to the surfaces; the cell's tape is then that of the joint.
void Cell::load_joint() {
    joint_ = tree_.joint_in(leaf_.morton);
    if (joint_ == nullptr) return;
    joined_ = {surface_place(joint_->joint.chooser), surface_place(joint_->joint.inside),
               surface_place(joint_->joint.outside)};
    surfaces_.push_back(octree::kJointSurface);
}

/// The model's surface that a surface of the cell is at a point; `negated` if it has the opposite inside.
std::uint32_t Cell::surface_at(std::size_t surface, const double* x, bool* negated) const {
    *negated = false;
    if (is_solid(surface)) return surface_of_solid(x);
    if (surfaces_[surface] != octree::kJointSurface) return surfaces_[surface];
    const octree::Joint& joint = joint_->joint;
    if (model_value(joint.chooser, x) < 0) return joint.inside;
    *negated = joint.negated;
    return joint.outside;
}

double Cell::model_value(std::uint32_t surface, const double* x) const {
    return surface_value(&model_.surfaces[surface], model_.expression_ops.data(), x[0], x[1], x[2]);
}

/// Place of a surface's root between two points of opposite signs, 0 to 1.
double Cell::root_between(std::size_t surface, const double* low, const double* high) const {
    if (is_solid(surface)) return solid_root(low, high);
    const auto root_of = [this](std::uint32_t s, const double* a, const double* b) {
        return segment_root(&model_.surfaces[s], model_.expression_ops.data(), a, b);
    };
    bool negated_low = false;
    bool negated_high = false;
    const std::uint32_t at_low = surface_at(surface, low, &negated_low);
    const std::uint32_t at_high = surface_at(surface, high, &negated_high);
    if (at_low == at_high) return root_of(at_low, low, high);
    // On the side of the third surface where the signs differ.
    const double t = root_of(joint_->joint.chooser, low, high);
    double middle[3];
    for (int j = 0; j < 3; ++j) middle[j] = low[j] + t * (high[j] - low[j]);
    const double from = model_value(at_low, low);
    const double to = model_value(at_low, middle);
    if ((from < 0) != (to < 0)) return t * root_of(at_low, low, middle);
    return t + (1 - t) * root_of(at_high, middle, high);
}

/// Where the joint is active, its three surfaces are not; where the solid is, no other.
void Cell::settle_stand_in(std::uint8_t* active) const {
    if (!has_stand_in() || active[surfaces_.size() - 1] == 0) return;
    if (crowded_) {
        std::fill(active, active + surfaces_.size() - 1, std::uint8_t{0});
    } else {
        for (const std::size_t s : joined_) active[s] = 0;
    }
}

/// Gives the joint the sign of that of its surfaces which is valid at a node, of an entity where it is not
/// active.
void Cell::sync_joint(LocalNode node) {
    const int side = sign(node, joined_[0]);
    const int inside = sign(node, joined_[1]);
    const int outside = joint_->joint.negated ? -sign(node, joined_[2]) : sign(node, joined_[2]);
    const int here = side < 0 ? inside : side > 0 ? outside : inside == outside ? inside : 0;
    set_sign(node, surfaces_.size() - 1, here);
}

/// The tapes by which both cells mesh the face: those over the joint, or the solid, if both have
/// it.
void Cell::load_patch_tapes(const Patch& patch) {
    const TreeNode& other = tree_.nio[patch.beyond];
    const bool joined = has_stand_in() && patch_active_.back() != 0;
    patch_tape_ = !has_stand_in() || joined ? &local_tape_ : &plain_tape_;
    const std::uint32_t* words = tree_.tapes.data() + other.tape_offset;
    std::size_t length = other.tape_length;
    if (joined) {
        const auto& tape = crowded_ ? crowd_tape_ : tree_.joint_in(other.morton)->tape;
        words = tape.data();
        length = tape.size();
    }
    tape::list_surfaces(words, length, other_surfaces_);
    other_tape_.load(words, length, other_surfaces_);
    other_to_own_.clear();
    for (const std::uint32_t surface : other_surfaces_) other_to_own_.push_back(surface_place(surface));
}

}  // namespace mortise::cnio
