// The page of a run in two dimensions.

run(Page, (page, view) => ({ triangles: () => view.frame.about.elements }));
