"""A page for each question: what a dataset says in sentences, tables and charts."""
