//! Columns of terms on one design matrix, each computed once: every question asks for those of everything that was found.

use crate::library::design_matrix::DesignMatrix;
use crate::library::term::Term;
use crate::search::hypothesis::Atom;
use std::cell::RefCell;
use std::rc::Rc;

/// Columns of a term, one for each free gain.
type Columns = Rc<Vec<Vec<f64>>>;

/// A design matrix that remembers columns.
pub(crate) struct Signatures<'a> {
    pub design: &'a DesignMatrix,
    known: RefCell<Vec<(Term, Columns)>>,
}

impl<'a> Signatures<'a> {
    pub fn new(design: &'a DesignMatrix) -> Self {
        Self { design, known: RefCell::default() }
    }

    /// Columns of a term.
    pub fn columns(&self, term: &Term) -> Columns {
        if let Some((_, columns)) = self.known.borrow().iter().find(|(known, _)| known == term) {
            return columns.clone();
        }
        let columns = Rc::new(self.design.columns(term));
        self.known.borrow_mut().push((*term, columns.clone()));
        columns
    }

    /// Those of an atom's columns that are fitted.
    pub fn active(&self, atom: &Atom) -> Vec<Vec<f64>> {
        let all = self.columns(&atom.term);
        atom.active.iter().filter_map(|i| all.get(*i).cloned()).collect()
    }
}
