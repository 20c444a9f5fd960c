#include "colmap_plugin/terminal_progress.h"

#include "colmap_plugin/text_output.h"
#include "nerf/util/interrupts.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include <sys/ioctl.h>
#include <unistd.h>

namespace structnerf {
namespace {

constexpr double kSecondsBetweenDraws = 0.1;
constexpr double kSecondsBetweenLines = 1;
constexpr double kFractionBetweenLines = 0.1;
constexpr int kBarWidth = 24;
constexpr int kStageWidth = 20;

double SystemSeconds() {
  return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::string PercentText(const double fraction) {
  return std::to_string(static_cast<int>(std::floor(100 * fraction))) + " %";
}

// Remaining time, loss and PSNR, as far as they are known.
std::string DetailText(const ProgressUpdate& update) {
  std::string text;
  char number[64];
  if (update.seconds_left >= 0 && update.fraction > 0 && update.fraction < 1) {
    text += ", " + DurationText(update.seconds_left) + " left";
  }
  if (!std::isnan(update.loss)) {
    snprintf(number, sizeof(number), ", loss %.4f", update.loss);
    text += number;
  }
  if (update.held_out_psnr >= 0) {
    snprintf(number,
             sizeof(number),
             ", held-out PSNR %.1f dB",
             update.held_out_psnr);
    text += number;
  }
  return text;
}

std::string BarText(const double fraction) {
  const int num_full = static_cast<int>(std::floor(fraction * kBarWidth));
  return "[" + std::string(num_full, '#') +
         std::string(kBarWidth - num_full, '.') + "]";
}

}  // namespace

TerminalProgress::Options TerminalProgress::OptionsFor(
    const int file_descriptor) {
  Options options;
  options.is_terminal = isatty(file_descriptor) == 1;
  winsize size = {};
  if (options.is_terminal && ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 &&
      size.ws_col > 0) {
    options.num_columns = size.ws_col;
  }
  return options;
}

TerminalProgress::TerminalProgress(std::ostream* stream, Options options)
    : stream_(stream), options_([&options]() {
        if (!options.seconds) {
          options.seconds = SystemSeconds;
        }
        return std::move(options);
      }()) {}

TerminalProgress::~TerminalProgress() {
  if (line_open_) {
    *stream_ << std::endl;
  }
}

void TerminalProgress::Report(const ProgressUpdate& update) {
  if (update.stage != last_update_.stage) {
    BeginStage(update.stage);
  }
  const double now = options_.seconds();
  ProgressUpdate shown = update;
  shown.fraction = std::clamp(update.fraction, 0.0, 1.0);
  if (shown.seconds_left < 0 && shown.fraction > 0) {
    shown.seconds_left =
        (now - stage_start_) * (1 - shown.fraction) / shown.fraction;
  }
  // The last known numbers stay visible.
  shown.loss = std::isnan(update.loss) ? last_update_.loss : update.loss;
  shown.held_out_psnr = update.held_out_psnr >= 0 ? update.held_out_psnr
                                                  : last_update_.held_out_psnr;
  last_update_ = shown;

  if (options_.is_terminal) {
    if (now - last_drawn_ >= kSecondsBetweenDraws) {
      last_drawn_ = now;
      Draw(shown);
    }
  } else {
    PrintLine(shown);
  }
}

bool TerminalProgress::ShouldStop() {
  if (ScopedInterrupts::Count() == 0) {
    return false;
  }
  if (!announced_stop_) {
    announced_stop_ = true;
    PrintSentence(
        "Stopping early; maps are still written if training has begun. Press "
        "Ctrl-C again to quit at once without writing anything.");
  }
  return true;
}

bool TerminalProgress::ShouldAbort() { return ScopedInterrupts::Count() >= 2; }

bool TerminalProgress::ShouldSave() {
  return ScopedInterrupts::WasTerminated();
}

void TerminalProgress::Note(const std::string& sentence) {
  PrintSentence(sentence);
}

void TerminalProgress::Warn(const std::string& sentence) {
  PrintSentence("Warning: " + sentence);
}

void TerminalProgress::Finish() {
  if (last_update_.stage.empty()) {
    return;
  }
  if (!options_.is_terminal) {
    last_update_.seconds_left = -1;
    *stream_ << last_update_.stage << ": done in "
             << DurationText(options_.seconds() - stage_start_)
             << DetailText(last_update_) << std::endl;
    last_update_ = ProgressUpdate();
    return;
  }
  char text[256];
  snprintf(text,
           sizeof(text),
           "\r\033[K%-*s %s",
           kStageWidth,
           last_update_.stage.c_str(),
           DurationText(options_.seconds() - stage_start_).c_str());
  *stream_ << text << std::endl;
  last_update_ = ProgressUpdate();
  line_open_ = false;
}

void TerminalProgress::BeginStage(const std::string& stage) {
  Finish();
  last_update_ = ProgressUpdate();
  last_update_.stage = stage;
  stage_start_ = options_.seconds();
  last_drawn_ = stage_start_ - 2 * kSecondsBetweenDraws;
  next_fraction_ = kFractionBetweenLines;
  if (!options_.is_terminal) {
    *stream_ << stage << std::endl;
    last_drawn_ = stage_start_;
  }
}

void TerminalProgress::PrintLine(const ProgressUpdate& update) {
  const double now = options_.seconds();
  if (update.fraction < next_fraction_ || update.fraction >= 1 ||
      now - last_drawn_ < kSecondsBetweenLines) {
    return;
  }
  *stream_ << update.stage << ": " << PercentText(update.fraction)
           << DetailText(update) << std::endl;
  last_drawn_ = now;
  next_fraction_ = (std::floor(update.fraction / kFractionBetweenLines) + 1) *
                   kFractionBetweenLines;
}

void TerminalProgress::Draw(const ProgressUpdate& update) {
  char stage[64];
  snprintf(stage, sizeof(stage), "%-*s ", kStageWidth, update.stage.c_str());
  std::string line = stage + BarText(update.fraction) + " " +
                     PercentText(update.fraction) + DetailText(update);
  // A line that wraps could not be redrawn in place.
  line.resize(
      std::min<size_t>(line.size(), std::max(1, options_.num_columns - 1)));
  *stream_ << "\r\033[K" << line << std::flush;
  line_open_ = true;
}

void TerminalProgress::PrintSentence(const std::string& sentence) {
  if (line_open_) {
    *stream_ << "\r\033[K";
  }
  *stream_ << sentence << std::endl;
  if (line_open_) {
    Draw(last_update_);
  }
}

}  // namespace structnerf
