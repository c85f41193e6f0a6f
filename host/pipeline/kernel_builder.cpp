#include <optional>

#include "host/device/build_record.hpp"
#include "host/device/device.hpp"
#include "host/pipeline/programs.hpp"
#include "mortise/kernels.hpp"

namespace mortise {

struct KernelBuilder::Implementation {
    std::string choice;
    device::DeviceOptions options;
    std::vector<device::ProgramName> programs;
    std::optional<device::Device> device;
};

KernelBuilder::KernelBuilder(std::string device, int work_group_size, std::string folder)
    : implementation_(new Implementation{std::move(device), {}, pipeline::kUsualPrograms, {}}) {
    Implementation& self = *implementation_;
    self.options.work_group_size = work_group_size;
    self.options.probe = false;
    self.options.cache_folder = std::move(folder);
    if (!self.options.cache_folder.empty()) {
        const auto& others = pipeline::kOtherPrograms;
        self.programs.insert(self.programs.end(), others.begin(), others.end());
    }
}
KernelBuilder::~KernelBuilder() = default;

std::size_t KernelBuilder::needed() const {
    const Implementation& self = *implementation_;
    return device::are_built(self.programs, self.choice, self.options) ? 0 : self.programs.size();
}

void KernelBuilder::build(std::size_t i) {
    Implementation& self = *implementation_;
    if (!self.device) self.device.emplace(self.choice, self.options);
    self.device->build(self.programs.at(i));
}

void KernelBuilder::finish() {
    const Implementation& self = *implementation_;
    // A folder for all serves runs that need the usual ones: they look for a note of these.
    device::remember_built(pipeline::kUsualPrograms, self.choice, self.options);
    device::remember_built(self.programs, self.choice, self.options);
}

}  // namespace mortise
