#include "host/snio/face_plans.hpp"

#include <memory>

namespace mortise::snio {
namespace {

void add_sets(FacePlans& plans) {
    for (u32 set = 0; set < 256; ++set) {
        for (u32 c = 0, power = 1; c < 8; ++c, power *= 3) {
            if (((set >> c) & 1) != 0) plans.cell_states[set] += power;
        }
        for (u32 f = 0; f < 6; ++f) {
            u64 power = 1;
            for (u32 i = 0; i < 4; ++i, power *= 3) {
                if (((set >> kFaceCorners[f][i]) & 1) == 0) continue;
                plans.states[set] += power << (8 * f);
                plans.corners[set] |= 1u << (4 * f + i);
            }
        }
    }
}

/// Corners of a face or cell in a state: for each a digit to base 3, 1 inside and 2 on the surface.
struct Corners {
    u32 inside = 0, on = 0;
    void add(u32 digit, u32 corner) {
        if (digit == 1) inside |= 1u << corner;
        if (digit == 2) on |= 1u << corner;
    }
};

std::unique_ptr<FacePlans> make_plans() {
    auto plans = std::make_unique<FacePlans>();  // zeros
    add_sets(*plans);
    LoopEdges edges[6][kFaceStates];
    for (int f = 0; f < 6; ++f) {
        for (u32 state = 0; state < kFaceStates; ++state) {
            Corners corners;
            u32 rest = state;
            for (const u8 corner : kFaceCorners[f]) {
                corners.add(rest % 3, corner);
                rest /= 3;
            }
            make_face_plan(corners.inside, corners.on, f, &plans->plan[f][state], &edges[f][state]);
        }
    }
    for (u32 state = 0; state < kCellStates; ++state) {
        Corners corners;
        u32 rest = state;
        for (u32 c = 0; c < 8; ++c, rest /= 3) corners.add(rest % 3, c);
        const u64 states = plans->states[corners.inside] + 2 * plans->states[corners.on];
        LoopEdges around[6];
        int size = 0;
        for (int f = 0; f < 6 && size >= 0; ++f) {
            const u32 face = (states >> (8 * f)) & 0xff;
            around[f] = edges[f][face];
            if (plans->plan[f][face].count == kNoPolygon) size = -1;
        }
        LoopPlan& plan = plans->loop[state];
        if (size >= 0) size = link_loop(around, plan.node);
        plan.size = static_cast<u8>(size < 0 ? kNoLoop : size);
    }
    return plans;
}

}  // namespace

const FacePlans& face_plans() {
    static const std::unique_ptr<FacePlans> plans = make_plans();
    return *plans;
}

}  // namespace mortise::snio
