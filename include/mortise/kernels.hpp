// Building OpenCL kernels before they are needed. A driver may compile one program at a time per process,
// whatever threads ask for (PoCL does), so a first run waits for all of them one by one; several processes
// share them out.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace mortise {

/// The kernel programs that every mesh needs, built into Mortise's cache folder one by one.
///
///     KernelBuilder builder;
///     /* in any process, each i once: */ for (i < builder.needed()) builder.build(i);
///     builder.finish();
class KernelBuilder {
  public:
    /// Arguments as MeshOptions::device and work_group_size.
    explicit KernelBuilder(std::string device = {}, int work_group_size = 0);
    ~KernelBuilder();
    KernelBuilder(const KernelBuilder&) = delete;
    KernelBuilder& operator=(const KernelBuilder&) = delete;

    /// How many programs there are to build: 0 if finish() was called before by any process with the same
    /// kernels, arguments and cache folder, or if there is no folder to keep them in. Opens no driver, so
    /// that the process can still be forked.
    std::size_t needed() const;

    /// Builds program `i` < needed(), if it is not in the cache folder; those that take longest come first.
    /// Opens the device at the first call. Throws Error(kDevice).
    void build(std::size_t i);

    /// Remembers that all programs have been built.
    void finish();

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace mortise
