// Benchmark models; see models.hpp.
#include "bench/models.hpp"

#include <cmath>
#include <cstdint>
#include <sstream>
#include <vector>

#include "host/common/random.hpp"

namespace mortise::bench {
namespace {

double between(Random& random, double low, double high) { return low + (high - low) * random.uniform(); }

/// A random rotation (by a unit quaternion) and a random place in the unit cube.
Affine random_placement(Random& random) {
    double q[4];
    double square = 0;
    do {
        square = 0;
        for (double& component : q) {
            component = between(random, -1, 1);
            square += component * component;
        }
    } while (square > 1 || square < 0.01);
    for (double& component : q) component /= std::sqrt(square);
    const double w = q[0];
    const double x = q[1];
    const double y = q[2];
    const double z = q[3];
    const double t[3] = {between(random, 0, 1), between(random, 0, 1), between(random, 0, 1)};
    return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),     t[0],
            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),     t[1],
            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y), t[2]};
}

constexpr std::uint64_t kRandomModels = 42;  ///< seed

/// Spheres, boxes, tori and capped cylinders in turn; every third one is cut out of the union of the others.
/// They shrink with their number such that their volumes add up to about half of the unit cube.
Model random_model(int count) {
    Model model;
    model.source = std::to_string(count) + " random primitives";
    Random random(kRandomModels);
    const double size = 0.5 / std::cbrt(static_cast<double>(count));
    std::vector<std::uint32_t> solid;
    std::vector<std::uint32_t> removed;
    for (int i = 0; i < count; ++i) {
        const double r = size * between(random, 0.7, 1.3);
        const double h = size * between(random, 0.7, 1.3);
        std::uint32_t node = 0;
        switch (i % 4) {
            case 0: node = model.add_primitive(sphere(r)); break;
            case 1: node = model.add_primitive(box({-r, -h, -r}, {r, h, r})); break;
            case 2: node = model.add_primitive(torus(r, 0.4 * h)); break;
            default: {
                const std::uint32_t side = model.add_primitive(infinite_cylinder(0.7 * r));
                const std::uint32_t slab = model.add_primitive(box({-r, -r, -h}, {r, r, h}));
                node = model.add_operation(CsgNode::Op::kIntersection, {side, slab});
            }
        }
        node = model.add_transform(random_placement(random), node);
        (i % 3 == 2 ? removed : solid).push_back(node);
    }
    std::vector<std::uint32_t> operands = {model.add_operation(CsgNode::Op::kUnion, solid)};
    operands.insert(operands.end(), removed.begin(), removed.end());
    Region region;
    region.name = "solid";
    region.root = model.add_operation(CsgNode::Op::kDifference, operands);
    model.regions.push_back(region);
    return model;
}

Model sphere_model() {
    Model model;
    model.source = "sphere";
    Region region;
    region.name = "sphere";
    region.root = model.add_primitive(sphere(1));
    model.regions.push_back(region);
    return model;
}

/// A cube of two regions, on grid planes: hexahedra only.
Model halves_model() {
    Model model;
    model.source = "halves";
    for (const double low : {0.0, 0.5}) {
        Region region;
        region.name = low > 0 ? "upper" : "lower";
        region.root = model.add_primitive(box({0, 0, low}, {1, 1, low + 0.5}));
        model.regions.push_back(region);
    }
    return model;
}

/// Round struts along all edges of 10 × 10 × 10 cells, cut at the lattice's own box.
Model lattice_model() {
    constexpr int kCells = 10;
    constexpr double kRadius = 0.15;  // of a cell
    Model model;
    model.source = "lattice";
    const std::uint32_t strut = model.add_primitive(infinite_cylinder(kRadius));
    std::vector<std::uint32_t> struts;
    for (int a = 0; a <= kCells; ++a) {
        for (int b = 0; b <= kCells; ++b) {
            const double u = a;
            const double v = b;
            struts.push_back(model.add_transform({1, 0, 0, u, 0, 1, 0, v, 0, 0, 1, 0}, strut));
            struts.push_back(model.add_transform({0, 0, 1, 0, 1, 0, 0, u, 0, 1, 0, v}, strut));
            struts.push_back(model.add_transform({0, 1, 0, u, 0, 0, 1, 0, 1, 0, 0, v}, strut));
        }
    }
    const double far = kCells + 0.5;
    const std::uint32_t all = model.add_operation(CsgNode::Op::kUnion, struts);
    const std::uint32_t limits = model.add_primitive(box({-0.5, -0.5, -0.5}, {far, far, far}));
    Region region;
    region.name = "lattice";
    region.root = model.add_operation(CsgNode::Op::kIntersection, {all, limits});
    model.regions.push_back(region);
    return model;
}

}  // namespace

Model make_model(const std::string& name) {
    if (name == "sphere") return sphere_model();
    if (name == "halves") return halves_model();
    if (name == "lattice") return lattice_model();
    if (name == "bracket") return read_model(MORTISE_SOURCE_DIR "/assets/models/bracket.csg");
    const std::string prefix = "random:";
    if (name.compare(0, prefix.size(), prefix) == 0) {
        const std::string digits = name.substr(prefix.size());
        if (digits.empty() || digits.size() > 5 ||
            digits.find_first_not_of("0123456789") != std::string::npos || std::stoi(digits) == 0) {
            throw Error(ExitCode::kUsage, "benchmark model '" + name +
                                              "': expected a number of primitives from 1 to 99999 after "
                                              "'random:', as in random:30");
        }
        return random_model(std::stoi(digits));
    }
    return read_model(name);
}

std::string random_bracket(std::uint32_t number) {
    Random random(number);
    const double length = between(random, 3.2, 5), width = between(random, 1.7, 2.6);
    const double base = between(random, 0.6, 1), wall = between(random, 0.6, 1);
    const double height = base + between(random, 1.4, 2.4);
    const double hole = between(random, 0.25, 0.4), boss = hole + between(random, 0.25, 0.4);
    const double boss_top = base + between(random, 0.3, 0.8);
    const double middle = width / 2;
    const double boss_at = wall + boss + between(random, 0.1, 0.3);
    const double hole_at = length - between(random, 0.5, 0.7);
    const double upper_at = (base + height) / 2;
    std::ostringstream text;
    const auto cylinder = [&](double r, double low, double high) {
        text << "translate([0, 0, " << low << "]) cylinder(r = " << r << ", h = " << high - low << ");\n";
    };
    text << "difference() {\nunion() {\n"
         << "cube([" << length << ", " << width << ", " << base << "]);\n"
         << "cube([" << wall << ", " << width << ", " << height << "]);\n"
         << "translate([" << boss_at << ", " << middle << ", 0]) ";
    cylinder(boss, 0, boss_top);
    text << "}\ntranslate([" << boss_at << ", " << middle << ", 0]) ";
    cylinder(hole, -1, boss_top + 1);
    text << "translate([" << hole_at << ", " << middle << ", 0]) ";
    cylinder(hole, -1, base + 1);
    text << "translate([0, " << middle << ", " << upper_at << "]) rotate([0, 90, 0]) ";
    cylinder(hole, -1, wall + 1);
    text << "}\n";
    return text.str();
}

}  // namespace mortise::bench
