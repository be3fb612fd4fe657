// What the C++ drivers share: the points, and the conversation with the program `peers` (README.md).
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

// What was built, by `build`.
#ifndef VERSION
#define VERSION "unknown"
#endif
#ifndef FLAGS
#define FLAGS "unknown flags"
#endif

using Points = std::vector<std::array<double, 3>>;
using Couples = std::vector<std::array<std::uint32_t, 2>>;

/// Says why this search cannot take part, and ends.
[[noreturn]] inline void refuse(const std::string& why) {
    std::cout << "error " << why << std::endl;
    std::exit(0);
}

/// The last four arguments: FILE DIMENSION CUTOFF THREADS. What comes before them is the driver's own.
struct Request {
    Points points;
    double cutoff;
    int threads;

    Request(int count, char** arguments) {
        if (count < 5) refuse("arguments: [OWN...] FILE DIMENSION CUTOFF THREADS");
        char** last = arguments + count - 4;
        if (std::string(last[1]) != "3") refuse("3D only");
        cutoff = std::atof(last[2]);
        threads = std::atoi(last[3]);
        std::FILE* file = std::fopen(last[0], "rb");
        if (file == nullptr) refuse("cannot open the points");
        std::fseek(file, 0, SEEK_END);
        points.resize(std::ftell(file) / sizeof(points[0]));
        std::rewind(file);
        const bool complete = std::fread(points.data(), sizeof(points[0]), points.size(), file) == points.size();
        std::fclose(file);
        if (!complete || points.empty()) refuse("cannot read the points");
    }
};

/// Says `how` it searches, then answers every `round` with the milliseconds of `detect` and the number of pairs that `count` then
/// tells, until the input ends.
template <typename Detect, typename Count>
void converse(const std::string& how, Detect detect, Count count) {
    std::cout << "ready " VERSION "; " << how << "; g++ " __VERSION__ " " FLAGS << std::endl;
    for (std::string line; std::getline(std::cin, line);) {
        if (line != "round") refuse("not a round: " + line);
        const auto start = std::chrono::steady_clock::now();
        detect();
        const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
        std::cout << time.count() << ' ' << count() << std::endl;
    }
}
