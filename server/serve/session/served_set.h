#pragma once

#include <memory>

#include "server/serve/session/catalog.h"
#include "server/serve/session/token_file.h"

namespace lode::serve {

/// What a server offers and to whom, at one time. Swapped whole at a reload.
struct ServedSet {
  std::shared_ptr<const Catalog> catalog;
  std::shared_ptr<const TokenFile> tokens;  ///< none: no token is asked for
};

}  // namespace lode::serve
