"""What a person looks at: sentences, figures, tables, the HTML page."""
