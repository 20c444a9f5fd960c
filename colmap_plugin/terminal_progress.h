#pragma once

#include "colmap_plugin/run_progress.h"

#include <functional>
#include <ostream>
#include <string>

namespace structnerf {

// Shows progress to a person. On a terminal, one line per stage that is redrawn
// in place, with a bar, the time that remains, loss and held-out PSNR;
// elsewhere, a plain line at the start and end and about every tenth of a
// stage, but not more than one per second.
//
// Stops and aborts as ScopedInterrupts counts Ctrl-C, and saves what is done if
// it was SIGTERM.
class TerminalProgress : public RunProgress {
 public:
  struct Options {
    bool is_terminal = false;
    int num_columns = 80;             // of the terminal
    std::function<double()> seconds;  // a clock; null = the system's
  };

  // How the stream of `file_descriptor` should be written to.
  static Options OptionsFor(int file_descriptor);

  // `stream` must outlive this object.
  TerminalProgress(std::ostream* stream, Options options);
  ~TerminalProgress() override;

  void Report(const ProgressUpdate& update) override;
  bool ShouldStop() override;
  bool ShouldAbort() override;
  bool ShouldSave() override;
  void Note(const std::string& sentence) override;
  void Warn(const std::string& sentence) override;

  // To be called when the last stage is complete.
  void Finish();

 private:
  void BeginStage(const std::string& stage);
  void PrintLine(const ProgressUpdate& update);
  void Draw(const ProgressUpdate& update);
  void PrintSentence(const std::string& sentence);

  std::ostream* stream_;
  const Options options_;
  ProgressUpdate last_update_;
  double stage_start_ = 0;    // seconds
  double last_drawn_ = 0;     // seconds
  double next_fraction_ = 0;  // of the next plain line
  bool line_open_ = false;    // the terminal's line is not ended yet
  bool announced_stop_ = false;
};

}  // namespace structnerf
