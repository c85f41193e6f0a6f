// A reader of input decks (.inp) for tests, with the solvers' own numbering of elements' faces.
#pragma once

#include <array>
#include <cstddef>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

struct Deck {
    struct Element {
        std::string type;
        std::string set;
        std::vector<int> nodes;
    };
    std::map<int, std::array<double, 3>> nodes;
    std::map<int, Element> elements;
    std::map<std::string, std::vector<std::string>> element_sets;  ///< of sets
    std::map<std::string, std::vector<int>> node_sets;
    std::map<std::string, std::vector<std::pair<int, int>>> surfaces;  ///< elements and faces, from 1
    std::vector<std::string> comments;
    std::size_t longest_number = 0, longest_line = 0;  ///< characters; entries

    explicit Deck(const std::string& path) {
        std::ifstream file(path);
        std::string keyword, unfinished;
        std::map<std::string, std::string> options;
        for (std::string line; std::getline(file, line);) {
            if (line.compare(0, 2, "**") == 0) {
                comments.push_back(line);
            } else if (line[0] == '*') {
                const std::vector<std::string> words = split(line);
                keyword = words[0];
                options.clear();
                for (std::size_t i = 1; i < words.size(); ++i) {
                    const std::size_t equals = words[i].find('=');
                    options[words[i].substr(0, equals)] = words[i].substr(equals + 1);
                }
            } else {
                std::size_t entries = split(line).size();
                if (line.back() == ',') --entries;
                longest_line = entries > longest_line ? entries : longest_line;
                unfinished += line;
                if (keyword == "*ELEMENT" && line.back() == ',') continue;
                add(keyword, options, split(unfinished));
                unfinished.clear();
            }
        }
    }

    /// Corners of face S of an element of this type: Abaqus Analysis User's Guide, element library.
    static std::vector<int> face(const std::string& type, int s) {
        using Faces = std::vector<std::vector<int>>;
        static const Faces brick = {{1, 2, 3, 4}, {5, 8, 7, 6}, {1, 5, 6, 2},
                                    {2, 6, 7, 3}, {3, 7, 8, 4}, {4, 8, 5, 1}};
        static const Faces wedge = {{1, 2, 3}, {4, 6, 5}, {1, 4, 5, 2}, {2, 5, 6, 3}, {3, 6, 4, 1}};
        static const Faces tetrahedron = {{1, 2, 3}, {1, 4, 2}, {2, 4, 3}, {3, 4, 1}};
        const Faces& faces = type == "C3D8" || type == "C3D20"   ? brick
                             : type == "C3D6" || type == "C3D15" ? wedge
                                                                 : tetrahedron;
        return faces.at(static_cast<std::size_t>(s - 1));
    }

    /// Middles follow the corners in this order of edges.
    static std::vector<std::pair<int, int>> edges(const std::string& type) {
        if (type == "C3D20")
            return {{1, 2}, {2, 3}, {3, 4}, {4, 1}, {5, 6}, {6, 7},
                    {7, 8}, {8, 5}, {1, 5}, {2, 6}, {3, 7}, {4, 8}};
        if (type == "C3D15") return {{1, 2}, {2, 3}, {3, 1}, {4, 5}, {5, 6}, {6, 4}, {1, 4}, {2, 5}, {3, 6}};
        if (type == "C3D10") return {{1, 2}, {2, 3}, {3, 1}, {1, 4}, {2, 4}, {3, 4}};
        return {};
    }

  private:
    static std::vector<std::string> split(const std::string& line) {
        std::vector<std::string> words;
        std::istringstream stream(line);
        for (std::string word; std::getline(stream, word, ',');) {
            const std::size_t begin = word.find_first_not_of(' ');
            words.push_back(begin == std::string::npos ? "" : word.substr(begin));
        }
        return words;
    }

    void add(const std::string& keyword, std::map<std::string, std::string>& options,
             const std::vector<std::string>& words) {
        if (keyword == "*NODE") {
            for (std::size_t i = 1; i < 4; ++i)
                longest_number = words.at(i).size() > longest_number ? words[i].size() : longest_number;
            nodes[std::stoi(words[0])] = {std::stod(words.at(1)), std::stod(words.at(2)),
                                          std::stod(words.at(3))};
        } else if (keyword == "*ELEMENT") {
            Element& element = elements[std::stoi(words[0])];
            element = {options.at("TYPE"), options.at("ELSET"), {}};
            for (std::size_t i = 1; i < words.size(); ++i) element.nodes.push_back(std::stoi(words[i]));
        } else if (keyword == "*ELSET") {
            for (const std::string& word : words) element_sets[options.at("ELSET")].push_back(word);
        } else if (keyword == "*NSET") {
            for (const std::string& word : words) node_sets[options.at("NSET")].push_back(std::stoi(word));
        } else if (keyword == "*SURFACE") {
            surfaces[options.at("NAME")].emplace_back(std::stoi(words.at(0)),
                                                      std::stoi(words.at(1).substr(1)));
        }
    }
};
