//! Strongly connected parts of a graph.

use std::collections::{BTreeMap, BTreeSet};

/// Sets of nodes that reach each other, each sorted; a graph without circles has none.
#[must_use]
pub fn circles(graph: &BTreeMap<String, BTreeSet<String>>) -> Vec<BTreeSet<String>> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        graph.keys().map(|from| (from.as_str(), reach(graph, from))).collect();
    let mut found: Vec<BTreeSet<String>> = Vec::new();
    for from in graph.keys() {
        if found.iter().any(|circle| circle.contains(from)) || !reached[from.as_str()].contains(from.as_str())
        {
            continue;
        }
        let back = |to: &&&str| reached.get(**to).is_some_and(|back| back.contains(from.as_str()));
        found.push(reached[from.as_str()].iter().filter(back).map(|node| (*node).to_owned()).collect());
    }
    found
}

/// Everything that follows from a node.
fn reach<'a>(graph: &'a BTreeMap<String, BTreeSet<String>>, from: &str) -> BTreeSet<&'a str> {
    let mut seen = BTreeSet::new();
    let mut left: Vec<&str> = graph.get(from).into_iter().flatten().map(String::as_str).collect();
    while let Some(node) = left.pop() {
        if seen.insert(node) {
            left.extend(graph.get(node).into_iter().flatten().map(String::as_str));
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(edges: &[(&str, &str)]) -> BTreeMap<String, BTreeSet<String>> {
        let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (from, to) in edges {
            graph.entry((*from).to_owned()).or_default().insert((*to).to_owned());
        }
        graph
    }

    #[test]
    fn only_circles_are_found() {
        assert!(circles(&graph(&[("a", "b"), ("b", "c"), ("a", "c")])).is_empty());
        let found =
            circles(&graph(&[("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"), ("e", "f"), ("f", "e")]));
        let found: Vec<String> =
            found.iter().map(|c| c.iter().map(String::as_str).collect::<Vec<_>>().join(" ")).collect();
        assert_eq!(found, ["a b c", "e f"]);
    }
}
