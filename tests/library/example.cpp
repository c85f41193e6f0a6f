// A plate with a hole, built in code, meshed for twenty radii by one mesher whose kernels stay loaded.
#include <cstdio>
#include <string>

#include <mortise/io.hpp>
#include <mortise/mesher.hpp>
#include <mortise/solid.hpp>
#include <mortise/version.hpp>

namespace {

mortise::Model plate(double radius) {
    const mortise::Solid block = mortise::box({0, 0, 0}, {4, 2, 0.5});
    const mortise::Solid hole = mortise::cylinder(radius, 0.5);
    return mortise::make_model(block - hole.translated({2, 1, 0}), "plate");
}

}  // namespace

int main(int count, char** arguments) {
    const std::string folder = count > 1 ? arguments[1] : ".";
    std::printf("Mortise %s\n", mortise::version());
    try {
        mortise::Mesher mesher;
        mortise::MeshOptions options;
        options.level = 4;
        for (int i = 1; i <= 20; ++i) {
            const mortise::Mesh mesh = mesher.generate(plate(0.04 * i), options);
            mortise::write_mesh(mesh, folder + "/plate" + std::to_string(i) + ".vtu");
        }
        mortise::MeshFileStream file(folder + "/large.vtu");  // part by part, within 2 GiB
        options.level = 6;
        options.memory = std::uint64_t{2} << 30;
        mesher.stream(plate(0.5), options, file);
        file.commit();
        mesher.generate(mortise::Model{}, options);
    } catch (const mortise::Error& error) {
        std::printf("as expected, a model without regions: %s\n", error.what());
        return error.code() == mortise::ExitCode::kInput ? 0 : 1;
    }
    return 1;
}
