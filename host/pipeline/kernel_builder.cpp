#include <optional>

#include "host/device/build_record.hpp"
#include "host/device/device.hpp"
#include "host/pipeline/programs.hpp"
#include "mortise/kernels.hpp"

namespace mortise {
using pipeline::kUsualPrograms;

struct KernelBuilder::Implementation {
    std::string choice;
    device::DeviceOptions options;
    std::optional<device::Device> device;
};

KernelBuilder::KernelBuilder(std::string device, int work_group_size)
    : implementation_(new Implementation{std::move(device), {}, {}}) {
    implementation_->options.work_group_size = work_group_size;
    implementation_->options.probe = false;
}
KernelBuilder::~KernelBuilder() = default;

std::size_t KernelBuilder::needed() const {
    const bool built = device::are_built(kUsualPrograms, implementation_->choice, implementation_->options);
    return built ? 0 : kUsualPrograms.size();
}

void KernelBuilder::build(std::size_t i) {
    Implementation& self = *implementation_;
    if (!self.device) self.device.emplace(self.choice, self.options);
    self.device->build(kUsualPrograms.at(i));
}

void KernelBuilder::finish() {
    device::remember_built(kUsualPrograms, implementation_->choice, implementation_->options);
}

}  // namespace mortise
