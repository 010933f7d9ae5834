#include "client/app/window/scene/patient_opener.h"

#include <utility>
#include <variant>

namespace lode::app {
namespace {

constexpr std::chrono::seconds kBetweenTries{5};

bool isAway(const Error& error) {
  return error.code() == ErrorCode::kNetwork || error.code() == ErrorCode::kTimeout;
}

}  // namespace

PatientOpener::PatientOpener(std::string target, stream::StreamOptions options,
                             std::chrono::milliseconds timeout)
    : target_(std::move(target)), options_(std::move(options)), timeout_(timeout) {
  begin();
}

void PatientOpener::begin() {
  next_try_.reset();
  try {
    Target target = parseTarget(target_);
    asks_server_ = std::holds_alternative<stream::ServedModel>(target);
    opener_.emplace(std::move(target), options_, core::Framing{}, timeout_);
  } catch (const Error& error) {
    fail(error);
  }
}

void PatientOpener::fail(const Error& error) {
  opener_.reset();
  progress_.error = error;
  if (isAway(error)) next_try_ = Clock::now() + kBetweenTries;
}

const ModelOpener::Progress& PatientOpener::look() {
  if (progress_.streamer != nullptr) return progress_;
  if (next_try_ && Clock::now() >= *next_try_) begin();
  if (!opener_) return progress_;
  ModelOpener::Progress now = opener_->progress();
  if (now.error) {
    fail(*now.error);
  } else {
    if (now.streamer == nullptr) now.error = std::move(progress_.error);
    progress_ = std::move(now);
  }
  return progress_;
}

}  // namespace lode::app
