// viewer/main.cpp: the `tessera` program.
#include "viewer/program.h"

int main(int argc, char** argv) {
    return tessera::runProgram(argc, argv);
}
