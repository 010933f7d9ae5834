#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"
#include "client/embed/lodestream.h"
#include "common/codec/model_summary.h"
#include "common/error.h"

/// What the C face hands out.
struct lodestream_cut {
  std::shared_ptr<const lode::core::Cut> cut;
  lode::ModelSummary model;
  uint64_t serial = 0;  // by its stream
};

namespace lode::embed {

/// Keeps a message for lodestream_last_error() on this thread.
void remember(const char* message) noexcept;

/// What a pointer of the caller's points to. @throws Error kUsage for NULL.
template <typename T>
T& given(T* pointer, const char* what, const char* remedy = "the address of one") {
  if (pointer == nullptr)
    throw Error(ErrorCode::kUsage, std::string("a NULL ") + what + " was given: give " + remedy);
  return *pointer;
}

/// Runs what a function of the C face does, from which nothing may be thrown. @return what that returns: 1,
/// or 0.
template <typename Work>
int guard(Work&& work) noexcept {
  try {
    work();
    return 1;
  } catch (const std::bad_alloc&) {
    remember(kOutOfMemory);
    return 0;
  } catch (const std::exception& error) {
    remember(error.what());
    return 0;
  }
}

/// What is seen is off by no more than that: a leaf at its original triangles may be, where core::Cut has
/// converged.
inline bool isWithin(const core::Cut& cut, float threshold_px) noexcept {
  return cut.converged && cut.max_error_px <= threshold_px;
}

/// It is not within its threshold, and nothing finer is to be had.
inline bool isFinest(const core::Cut& cut) noexcept {
  return cut.converged && !isWithin(cut, cut.threshold_px);
}

/// The C face's camera in the model's frame. @throws Error kUsage if it is none.
core::View toView(const lodestream_view& view, const ModelSummary& model);

}  // namespace lode::embed
