// Scaled Jacobians of a finished mesh: host, own kernel, CLBlast's product.
#include <chrono>

#include "bench/models.hpp"
#include "bench/workers.hpp"
#include "host/jacobian/jacobian.hpp"
#include "mortise/error.hpp"
#include "mortise/mesher.hpp"

namespace mortise::bench {
namespace {

template <class Action>
double seconds_of(const Action& action) {
    const auto begin = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

nlohmann::json measure_jacobians(const Task& task) {
    using jacobian::Method;
    MeshOptions options;
    options.threads = task.threads;
    options.level = task.level;
    const Mesh mesh = generate_mesh(make_model(task.model), options);
    device::Device device;
    std::vector<float> own, product;
    const auto run_own = [&] { own = jacobian::scaled_jacobians(device, mesh, Method::kOwn); };
    const auto run_product = [&] { product = jacobian::scaled_jacobians(device, mesh, Method::kProduct); };

    nlohmann::json result = {{"device", device.info().name},
                             {"is_gpu", device.info().is_gpu},
                             {"elements", mesh.element_count()},
                             {"own_first_seconds", seconds_of(run_own)},
                             {"product_first_seconds", seconds_of(run_product)},
                             {"runs", nlohmann::json::array()}};
    if (own != product) throw Error(ExitCode::kMeshing, "the two ways to scaled Jacobians differ");
    for (int run = 0; run < task.repeats; ++run) {
        const double host =
            seconds_of([&] { jacobian::scaled_jacobians(device, mesh, Method::kHost, task.threads); });
        const double by_own = seconds_of(run_own);
        result["runs"].push_back(
            {{"host_seconds", host}, {"own_seconds", by_own}, {"product_seconds", seconds_of(run_product)}});
    }
    return result;
}

}  // namespace mortise::bench
