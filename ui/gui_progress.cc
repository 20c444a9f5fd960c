#include "ui/gui_progress.h"

#include <cmath>

#include <glog/logging.h>

namespace structnerf {
namespace {

// Shares of a stage before which its duration is not guessed.
constexpr double kMinFractionToGuess = 0.05;

void AddPoint(const double fraction,
              const double value,
              std::vector<CurvePoint>* curve) {
  if (curve->empty() || curve->back().value != value) {
    curve->push_back({fraction, value});
  }
}

}  // namespace

void GuiProgress::Report(const ProgressUpdate& update) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (update.stage != state_.stage) {
    state_.stage = update.stage;
    stage_begin_ = Clock::now();
    LOG(INFO) << "StructNeRF: " << update.stage;
  }
  state_.fraction = update.fraction;
  state_.seconds_left = update.seconds_left;
  if (update.seconds_left < 0 && update.fraction > kMinFractionToGuess) {
    const double seconds =
        std::chrono::duration<double>(Clock::now() - stage_begin_).count();
    state_.seconds_left = seconds * (1 - update.fraction) / update.fraction;
  }
  if (!std::isnan(update.loss)) {
    AddPoint(update.fraction, update.loss, &state_.loss);
  }
  if (update.held_out_psnr >= 0) {
    AddPoint(update.fraction, update.held_out_psnr, &state_.held_out_psnr);
  }
}

bool GuiProgress::ShouldStop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return should_stop_ || should_abort_;
}

bool GuiProgress::ShouldAbort() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return should_abort_;
}

bool GuiProgress::ShouldSave() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return should_save_;
}

void GuiProgress::BlockWhilePaused() {
  std::unique_lock<std::mutex> lock(mutex_);
  if (!state_.is_paused) {
    return;
  }
  const Clock::time_point begin = Clock::now();
  resumed_.wait(lock, [this]() { return !state_.is_paused; });
  stage_begin_ += Clock::now() - begin;
}

void GuiProgress::ShowPreview(const Preview& preview) {
  auto copy = std::make_shared<const Preview>(preview);
  const std::lock_guard<std::mutex> lock(mutex_);
  state_.preview = std::move(copy);
}

std::string GuiProgress::PreviewImage() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return preview_image_;
}

void GuiProgress::SetPaused(const bool is_paused) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    // Whoever wants an end has no use for a pause.
    state_.is_paused = is_paused && !state_.is_stopping;
  }
  resumed_.notify_all();
}

void GuiProgress::Stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    should_stop_ = true;
    state_.is_stopping = true;
    state_.is_paused = false;
  }
  resumed_.notify_all();
}

void GuiProgress::Abort() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    should_abort_ = true;
    state_.is_stopping = true;
    state_.is_paused = false;
  }
  resumed_.notify_all();
}

void GuiProgress::Suspend() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    should_save_ = true;
  }
  Abort();
}

void GuiProgress::WatchImage(const std::string& name) {
  const std::lock_guard<std::mutex> lock(mutex_);
  preview_image_ = name;
}

RunState GuiProgress::State() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

}  // namespace structnerf
