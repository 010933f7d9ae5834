#include "client/app/cli/not_converged.h"

#include "common/error.h"

namespace lode::app {

void refuseUnconverged(const std::string& where, const stream::StreamStatus& status,
                       const CommonOptions& options) {
  const std::string what = options.target + " did not converge at " + where;
  if (!status.failure.empty()) throw Error(ErrorCode::kNetwork, what + ": " + status.failure);
  if (status.limited)
    throw Error(ErrorCode::kLimit,
                what + ": the memory budget does not hold it; allow more with --memory-budget, or a larger " +
                    "error with --pixels");
  if (status.cut && status.cut->converged && status.cut->max_error_px > options.pixels)
    throw Error(ErrorCode::kInput,
                what + ": even the original triangles are off by " +
                    std::to_string(status.cut->max_error_px) +
                    " pixels so near, that is the lattice's step: the cut holds them all; allow a larger " +
                    "error with --pixels");
  const std::string remedy = "; allow more with --timeout, or a larger error with --pixels";
  throw Error(ErrorCode::kTimeout, what + " within " + std::to_string(options.timeout().count()) + " ms" +
                                       (status.trouble.empty() ? remedy : ": " + status.trouble));
}

}  // namespace lode::app
