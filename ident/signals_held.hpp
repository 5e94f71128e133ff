#pragma once

#include <csignal>

namespace struna::ident {

/// Holds back the signals that end a program (SIGINT, SIGTERM, SIGHUP) while it lives: for the moment in
/// which a file is written beside its place and renamed, so that an interrupt leaves no part of it.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t ending;
    sigemptyset(&ending);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&ending, signal);
    pthread_sigmask(SIG_BLOCK, &ending, &before_);
  }
  ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace struna::ident
