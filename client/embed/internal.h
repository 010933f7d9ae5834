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

/// A reference to a cut, as lodestream_take_cut() returns it.
struct lodestream_cut {
  std::shared_ptr<const lode::core::Cut> cut;
  lode::ModelSummary model;
  uint64_t serial = 0;  // lodestream_status::cut_serial
};

namespace lode::embed {

/// Returns the words for a remedy, which name options of the C API. Returns an empty text for kNone.
const char* wordsFor(Remedy remedy) noexcept;

/// Stores a message for lodestream_last_error() on this thread, followed by the words for its remedy.
void setLastError(const char* message, Remedy remedy = Remedy::kNone) noexcept;

/// Dereferences an argument of the C API. @throws Error kUsage if the pointer is NULL.
/// @param what    name of the argument for the message.
/// @param remedy  correct argument for the message.
template <typename T>
T& given(T* pointer, const char* what, const char* remedy = "the address of one") {
  if (pointer == nullptr)
    throw Error(ErrorCode::kUsage, std::string("the ") + what + " is NULL: pass " + remedy);
  return *pointer;
}

/// Runs the body of a C API function and converts exceptions. @return 1 on success, 0 on failure.
template <typename Work>
int guard(Work&& work) noexcept {
  try {
    work();
    return 1;
  } catch (const Error& error) {
    setLastError(error.what(), error.remedy());
    return 0;
  } catch (const std::bad_alloc&) {
    setLastError(kOutOfMemory);
    return 0;
  } catch (const std::exception& error) {
    setLastError(error.what());
    return 0;
  }
}

/// Returns true if no visible part exceeds the threshold. A converged core::Cut may exceed the threshold at
/// leaves with their original triangles.
inline bool isWithin(const core::Cut& cut, float threshold_px) noexcept {
  return cut.converged && cut.max_error_px <= threshold_px;
}

/// Returns true if the cut exceeds its threshold although it is the finest that the model has.
inline bool isFinest(const core::Cut& cut) noexcept {
  return cut.converged && !isWithin(cut, cut.threshold_px);
}

/// Converts a view to the model frame. @throws Error kUsage if the view is invalid.
core::View toView(const lodestream_view& view, const ModelSummary& model);

}  // namespace lode::embed
