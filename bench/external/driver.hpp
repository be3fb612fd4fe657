// What the C++ drivers share: the bodies, and the conversation with the program `peers` (README.md).
#pragma once

#include <algorithm>
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

/// The last four arguments: FILE DIMENSION KIND THREADS. What comes before them is the driver's own.
struct Request {
    std::vector<double> numbers;
    /// "points", with the cut-off, "radii" or "boxes".
    std::string kind = "points";
    double cutoff = 0.0;
    int threads;

    /// `kinds`: what this search can do.
    Request(int count, char** arguments, const std::vector<std::string>& kinds) {
        if (count < 5) refuse("arguments: [OWN...] FILE DIMENSION KIND THREADS");
        char** last = arguments + count - 4;
        if (std::string(last[1]) != "3") refuse("3D only");
        const std::string word = last[2];
        if (word == "radii" || word == "boxes") {
            kind = word;
        } else {
            cutoff = std::atof(last[2]);
        }
        if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
            refuse(kind == "radii" ? "one distance for all" : "points only");
        }
        threads = std::atoi(last[3]);
        std::FILE* file = std::fopen(last[0], "rb");
        if (file == nullptr) refuse("cannot open the bodies");
        std::fseek(file, 0, SEEK_END);
        numbers.resize(std::ftell(file) / sizeof(double) / width() * width());
        std::rewind(file);
        const bool complete = std::fread(numbers.data(), sizeof(double), numbers.size(), file) == numbers.size();
        std::fclose(file);
        if (!complete || numbers.empty()) refuse("cannot read the bodies");
    }

    /// Numbers of a body.
    std::size_t width() const { return kind == "points" ? 3 : kind == "radii" ? 4 : 6; }

    std::size_t size() const { return numbers.size() / width(); }

    /// For searches of points only.
    Points points() const {
        Points points(size());
        for (std::size_t i = 0; i < points.size(); i++) std::copy_n(&numbers[3 * i], 3, points[i].begin());
        return points;
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
