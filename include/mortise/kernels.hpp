// Building OpenCL kernels before they are needed. A driver may compile one program at a time per process,
// whatever threads ask for (PoCL does), so a first run waits for all of them one by one; several processes
// share them out.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace mortise {

/// Kernel programs, built one by one: those that every mesh needs, into Mortise's cache folder; or all, into
/// a folder that later runs may read (README.md, "Installing").
///
///     KernelBuilder builder;
///     /* in any process, each i once: */ for (i < builder.needed()) builder.build(i);
///     builder.finish();
class KernelBuilder {
  public:
    /// Arguments as MeshOptions::device and work_group_size; `folder`: where all programs go, instead of
    /// those that every mesh needs into the cache folder.
    explicit KernelBuilder(std::string device = {}, int work_group_size = 0, std::string folder = {});
    ~KernelBuilder();
    KernelBuilder(const KernelBuilder&) = delete;
    KernelBuilder& operator=(const KernelBuilder&) = delete;

    /// How many programs there are to build: 0 if finish() was called before by any process with the same
    /// kernels and arguments, on such a processor, for this folder or (the cache folder only) for one that
    /// was installed with Mortise; or if the folder cannot be written. Opens no driver, so that the process
    /// can still be forked.
    std::size_t needed() const;

    /// Builds program `i` < needed(), if it is not in the folder; those that take longest come first.
    /// Opens the device at the first call. Throws Error(kDevice), std::out_of_range for another i.
    void build(std::size_t i);

    /// Remembers that all programs have been built.
    void finish();

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace mortise
