// Matrix products by CLBlast: the only user of its header. CLBlast builds its kernels at the first product of
// a process, which takes long on CPU devices; nothing else here may touch it.
#include <clblast.h>

#include "host/device/device_state.hpp"

namespace mortise::device {

Event Device::multiply(const Buffer& a, const Buffer& b, Buffer& c, std::size_t m, std::size_t n,
                       std::size_t k) {
    static const std::string entry = "clblast_gemm";
    Implementation& self = *implementation_;
    Event event;
    if (m == 0 || n == 0) return event;
    const std::string what = "product of a " + std::to_string(m) + " × " + std::to_string(k) + " and a " +
                             std::to_string(k) + " × " + std::to_string(n) + " matrix";
    if (k == 0) misuse(what + ": nothing to add up");
    const auto require = [&what](const Buffer& buffer, std::size_t count, const char* name) {
        if (!buffer.implementation_ || buffer.implementation_->mappings != 0) {
            misuse(what + ": " + name + " is " +
                   (buffer ? "a buffer that is still mapped" : "an empty buffer"));
        }
        if (buffer.count<double>() < count) {
            misuse(what + ": " + name + " has " + std::to_string(buffer.count<double>()) +
                   " numbers, expected at least " + std::to_string(count));
        }
    };
    require(a, m * k, "the first");
    require(b, k * n, "the second");
    require(c, m * n, "the result");
    cl_command_queue queue = self.queue.get();
    cl_event finished = nullptr;
    const clblast::StatusCode code = clblast::Gemm<double>(
        clblast::Layout::kColMajor, clblast::Transpose::kNo, clblast::Transpose::kNo, m, n, k, 1.0,
        a.implementation_->memory.get(), 0, m, b.implementation_->memory.get(), 0, k, 0.0,
        c.implementation_->memory.get(), 0, m, &queue, &finished);
    if (code != clblast::StatusCode::kSuccess) {
        // CLBlast passes OpenCL's codes on and adds its own below -1000.
        fail(static_cast<cl_int>(code), "clblast::Gemm", what + " on " + info().name);
    }
    event.implementation_ = std::make_shared<Event::Implementation>();
    event.implementation_->entry = entry;
    event.implementation_->handle = compute::event(finished, false);
    const auto known = std::find_if(self.times.begin(), self.times.end(),
                                    [](const KernelTime& time) { return time.entry == entry; });
    const auto index = static_cast<std::size_t>(known - self.times.begin());
    if (known == self.times.end()) {
        self.times.emplace_back();
        self.times.back().entry = entry;
    }
    ++self.times[index].launches;
    self.times[index].items += m * n;
    self.pending.push_back({event.implementation_->handle, index});
    return event;
}

}  // namespace mortise::device
