#pragma once

#include <functional>
#include <list>
#include <mutex>
#include <string>

// SIGINT and SIGTERM end a program within a second wherever it is: a thread of its own answers them, so that
// no loop and no engine has to look for them.

namespace touchstone::program {

/// Makes SIGINT and SIGTERM end the program with 128 + the signal, after all answers: once a program.
/// @param name of the program, printed before its messages.
void answer_signals(const std::string& name);

/// No answer runs while this is held: for what an answer reads, and for what must not end half done. To be
/// held for a moment only.
std::unique_lock<std::recursive_mutex> hold_interrupts();

/// Never returns once a signal has come: the program ends, and no more is begun.
void stop_if_interrupted();

/// While it lives, `answer` is called before a signal ends the program, the newest first. It runs on a thread
/// of its own while the others go on.
/// @param answer returns the text to be printed on stderr; empty: nothing.
class OnInterrupt {
 public:
  explicit OnInterrupt(std::function<std::string()> answer);
  ~OnInterrupt();
  OnInterrupt(const OnInterrupt&) = delete;
  OnInterrupt& operator=(const OnInterrupt&) = delete;

 private:
  std::list<std::function<std::string()>>::iterator place_;
};

}  // namespace touchstone::program
