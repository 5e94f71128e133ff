#include "apps/commands.hpp"

int main(int argc, char** argv) {
  return struna::apps::run(argc, argv);
}
