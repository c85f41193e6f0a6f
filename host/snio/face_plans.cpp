#include "host/snio/face_plans.hpp"

#include <memory>

namespace mortise::snio {
namespace {

void add_sets(FacePlans& plans) {
    for (u32 set = 0; set < 256; ++set) {
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

std::unique_ptr<FacePlans> make_plans() {
    auto plans = std::make_unique<FacePlans>();  // zeros
    add_sets(*plans);
    for (int f = 0; f < 6; ++f) {
        for (u32 state = 0; state < kFaceStates; ++state) {
            u32 inside = 0;
            u32 on = 0;
            u32 rest = state;
            for (const u8 corner : kFaceCorners[f]) {
                if (rest % 3 == 1) inside |= 1u << corner;
                if (rest % 3 == 2) on |= 1u << corner;
                rest /= 3;
            }
            make_face_plan(inside, on, f, &plans->plan[f][state]);
        }
    }
    return plans;
}

}  // namespace

const FacePlans& face_plans() {
    static const std::unique_ptr<FacePlans> plans = make_plans();
    return *plans;
}

}  // namespace mortise::snio
